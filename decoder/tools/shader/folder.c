/* A folder that is whole or absent. See folder.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "folder.h"

#include "decoder/temporary.h"
#include "decoder/toolkit/file.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FILE_NAME_BYTES = 256 }; /* room in a path for the name of a file of the folder */

struct folder {
    char path[PATH_MAX], temporary[PATH_MAX], file[PATH_MAX];
    folder_is_ours *is_ours;
    btf_log log;
    int lock;   /* descriptor of the temporary folder */
    bool there; /* something is to be replaced */
};

static bool is_dot(const char *name) {
    return !strcmp(name, ".") || !strcmp(name, "..");
}

static int open_folder(int parent, const char *path) {
    return openat(parent, path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

/* Whether the open folder is still the one at this path. */
static bool is_at(int fd, const char *path) {
    struct stat opened, named;
    return fstat(fd, &opened) == 0 && lstat(path, &named) == 0 && opened.st_dev == named.st_dev &&
           opened.st_ino == named.st_ino;
}

/* Removes a folder, with the files in it that are ours. Links are not followed. */
static void remove_folder(const char *path, folder_is_ours *is_ours) {
    const int fd = open_folder(AT_FDCWD, path);
    DIR *listing = fd < 0 ? NULL : fdopendir(fd);
    if (listing) {
        for (struct dirent *entry; (entry = readdir(listing));) {
            if (is_ours(entry->d_name) || entry->d_name[0] == '.') { /* or the temporary file of one */
                unlinkat(dirfd(listing), entry->d_name, 0);
            }
        }
        closedir(listing);
    } else if (fd >= 0) {
        close(fd);
    }
    rmdir(path);
}

/* Removes the temporary folders of this name that can be locked. */
static void remove_stale(const char *parent, const char *name, size_t length, folder_is_ours *is_ours) {
    DIR *listing = opendir(parent);
    char path[PATH_MAX];
    if (!listing) {
        return;
    }
    for (struct dirent *entry; (entry = readdir(listing));) {
        if (!btfi_is_temporary_of(entry->d_name, name, length) ||
            snprintf(path, sizeof path, "%s/%s", parent, entry->d_name) >= (int)sizeof path) {
            continue;
        }
        const int fd = open_folder(dirfd(listing), entry->d_name);
        if (fd < 0) {
            continue;
        }
        if (flock(fd, LOCK_EX | LOCK_NB) == 0 && is_at(fd, path)) {
            remove_folder(path, is_ours);
        }
        close(fd);
    }
    closedir(listing);
}

/* Makes f->temporary and locks it; false with errno set. Between the two steps another run may take the folder for a
 * stale one: then it is left to that run, and the next name is tried. Where the file system has no locks, no run takes
 * it. */
static bool make_temporary(folder *f, const char *parent, const char *name, size_t length) {
    for (int attempt = 0; attempt < 100; attempt++) {
        if (snprintf(f->temporary, sizeof f->temporary, "%s/.%.*s.%ld-%d.tmp", parent, (int)length, name,
                     (long)getpid(), attempt) >= (int)sizeof f->temporary - FILE_NAME_BYTES) {
            errno = ENAMETOOLONG;
            return false;
        }
        if (mkdir(f->temporary, 0777) != 0) {
            if (errno == EEXIST) {
                continue;
            }
            return false;
        }
        f->lock = open_folder(AT_FDCWD, f->temporary);
        if (f->lock < 0) {
            if (errno == ENOENT) {
                continue;
            }
            const int error = errno;
            rmdir(f->temporary);
            errno = error;
            return false;
        }
        if ((flock(f->lock, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) &&
            is_at(f->lock, f->temporary)) {
            return true;
        }
        close(f->lock);
    }
    errno = EEXIST;
    return false;
}

/* Demands that the path is free, or a folder that may be replaced. */
static btf_result check_place(folder *f, bool replace) {
    struct stat status;
    if (lstat(f->path, &status) != 0) {
        if (errno == ENOENT) {
            return BTF_OK;
        }
        file_say(&f->log, "%s: cannot make the folder: %s", f->path, strerror(errno));
        return BTF_ERROR_IO;
    }
    DIR *listing = S_ISDIR(status.st_mode) ? opendir(f->path) : NULL;
    if (!listing) {
        file_say(&f->log, "%s: %s", f->path,
                 S_ISDIR(status.st_mode) ? strerror(errno)
                                         : "exists and is not a folder; it is not replaced");
        return BTF_ERROR_IO;
    }
    char stranger[256] = "";
    bool empty = true;
    for (struct dirent *entry; (entry = readdir(listing));) {
        if (!is_dot(entry->d_name)) {
            empty = false;
            if (!f->is_ours(entry->d_name)) {
                snprintf(stranger, sizeof stranger, "%s", entry->d_name);
            }
        }
    }
    closedir(listing);
    f->there = !empty;
    if (!empty && !replace) {
        file_say(&f->log, "%s: the folder exists; --force replaces it", f->path);
        return BTF_ERROR_IO;
    }
    if (stranger[0]) {
        file_say(&f->log, "%s: holds '%s', which btf-shader does not write; the folder is not replaced",
                 f->path, stranger);
        return BTF_ERROR_IO;
    }
    return BTF_OK;
}

btf_result folder_open(const char *path, bool replace, folder_is_ours *is_ours, const btf_log *log,
                       folder **out_folder) {
    *out_folder = NULL;
    folder *f = calloc(1, sizeof *f);
    if (!f) {
        file_say(log, "%s: out of memory", path);
        return BTF_ERROR_MEMORY;
    }
    f->is_ours = is_ours;
    f->log = *log;
    size_t length = strlen(path);
    while (length > 1 && path[length - 1] == '/') {
        length--;
    }
    char parent[PATH_MAX];
    const bool fits = length < sizeof f->path - 64;
    if (fits) {
        memcpy(f->path, path, length);
    }
    const char *slash = strrchr(f->path, '/'), *name = slash ? slash + 1 : f->path;
    snprintf(parent, sizeof parent, "%.*s", slash ? (int)(slash - f->path) : 1, slash ? f->path : ".");
    if (slash == f->path) {
        snprintf(parent, sizeof parent, "/");
    }
    if (!fits || !*name || is_dot(name)) {
        file_say(log, "%.200s: not the name of a folder that can be made", path);
        free(f);
        return BTF_ERROR_IO;
    }
    btf_result result = check_place(f, replace);
    if (!result) {
        const size_t counted = strnlen(name, BTFI_TEMPORARY_NAME_BYTES);
        remove_stale(parent, name, counted, is_ours);
        if (!make_temporary(f, parent, name, counted)) {
            file_say(log, "%s: cannot make the folder: %s", f->path, strerror(errno));
            result = BTF_ERROR_IO;
        }
    }
    if (result) {
        free(f);
    } else {
        *out_folder = f;
    }
    return result;
}

const char *folder_file(folder *f, const char *name) {
    const int length = snprintf(f->file, sizeof f->file, "%s/%s", f->temporary, name);
    return length < (int)sizeof f->file ? f->file : NULL;
}

/* Lets the new folder and the one that is there change places: in one step where the file system can, else in three,
 * between which nothing is at the path. */
static int exchange(folder *f) {
    if (renameat2(AT_FDCWD, f->temporary, AT_FDCWD, f->path, RENAME_EXCHANGE) == 0) {
        return 0;
    }
    if (errno != EINVAL && errno != ENOSYS) {
        return -1;
    }
    char old[PATH_MAX + 8];
    snprintf(old, sizeof old, "%s.old", f->temporary);
    if (rename(f->path, old) != 0) {
        return -1;
    }
    if (rename(f->temporary, f->path) != 0) {
        const int error = errno;
        (void)!rename(old, f->path);
        errno = error;
        return -1;
    }
    return rename(old, f->temporary);
}

btf_result folder_commit(folder **folder_to_commit) {
    folder *f = *folder_to_commit;
    /* rename replaces an empty folder */
    const int failed = f->there ? exchange(f) : rename(f->temporary, f->path);
    const btf_result result = failed ? BTF_ERROR_IO : BTF_OK;
    if (failed) {
        file_say(&f->log, "%s: cannot rename %s: %s", f->path, f->temporary, strerror(errno));
    }
    if (failed || f->there) {
        remove_folder(f->temporary, f->is_ours);
    }
    close(f->lock);
    free(f);
    *folder_to_commit = NULL;
    return result;
}

void folder_abort(folder **f) {
    if (f && *f) {
        remove_folder((*f)->temporary, (*f)->is_ours);
        close((*f)->lock);
        free(*f);
        *f = NULL;
    }
}
