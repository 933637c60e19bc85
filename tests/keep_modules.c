/* tests/run.sh preloads this into programs under LeakSanitizer. It replaces dlclose, so that no module is unloaded.
 * Memory that a GL or Vulkan driver still holds when its loader unloads it would be reported as leaked by a module
 * without a name, which no suppression can match. OpenBTF itself unloads nothing.
 *
 * SPDX-License-Identifier: MIT
 */
int dlclose(void *handle);

int dlclose(void *handle) {
    (void)handle;
    return 0;
}
