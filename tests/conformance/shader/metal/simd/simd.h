// Metal's text includes this header but uses nothing of it.
