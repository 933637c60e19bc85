/* Drops a file onto a window as a file manager does (the XDND protocol, version 5): x_drop WINDOW PATH.
 * Exit code 0 when the window took it, 1 when it did not answer within five minutes.
 *
 * SPDX-License-Identifier: MIT
 */
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct drop {
    Display *display;
    Window source, target;
    Atom selection, list;
    char uri[4200];
} drop;

static Atom atom(const drop *d, const char *name) {
    return XInternAtom(d->display, name, False);
}

static void send(const drop *d, const char *type, long a, long b, long c, long e) {
    XEvent event = {0};
    event.xclient.type = ClientMessage;
    event.xclient.window = d->target;
    event.xclient.message_type = atom(d, type);
    event.xclient.format = 32;
    const long words[5] = {(long)d->source, a, b, c, e};
    for (int i = 0; i < 5; i++) {
        event.xclient.data.l[i] = words[i];
    }
    XSendEvent(d->display, d->target, False, NoEventMask, &event);
    XFlush(d->display);
}

/* Hands the list of files over. */
static void answer(const drop *d, const XSelectionRequestEvent *request) {
    XEvent event = {0};
    XChangeProperty(d->display, request->requestor, request->property, d->list, 8, PropModeReplace,
                    (const unsigned char *)d->uri, (int)strlen(d->uri));
    event.xselection.type = SelectionNotify;
    event.xselection.requestor = request->requestor;
    event.xselection.selection = request->selection;
    event.xselection.target = request->target;
    event.xselection.property = request->property;
    event.xselection.time = request->time;
    XSendEvent(d->display, request->requestor, False, NoEventMask, &event);
    XFlush(d->display);
}

/* Waits for a client message, answering requests meanwhile. */
static int wait_for(const drop *d, const char *type) {
    const struct timespec pause = {0, 20000000};
    const Atom wanted = atom(d, type);
    for (int i = 0; i < 15000; i++) { /* five minutes, for a window that hangs */
        while (XPending(d->display)) {
            XEvent event;
            XNextEvent(d->display, &event);
            if (event.type == SelectionRequest) {
                answer(d, &event.xselectionrequest);
            }
            if (event.type == ClientMessage && event.xclient.message_type == wanted) {
                return 1;
            }
        }
        nanosleep(&pause, NULL);
    }
    return 0;
}

int main(int argc, char **argv) {
    drop d = {.display = XOpenDisplay(NULL)};
    char *path = argc == 3 ? realpath(argv[2], NULL) : NULL;
    if (!d.display || !path) {
        fprintf(stderr, "usage: x_drop WINDOW PATH, with a display and a file that is there\n");
        return 2;
    }
    snprintf(d.uri, sizeof d.uri, "file://%s\r\n", path);
    free(path);
    d.target = (Window)strtoul(argv[1], NULL, 0);
    d.source = XCreateSimpleWindow(d.display, DefaultRootWindow(d.display), 0, 0, 1, 1, 0, 0, 0);
    d.selection = atom(&d, "XdndSelection");
    d.list = atom(&d, "text/uri-list");
    XSetSelectionOwner(d.display, d.selection, d.source, CurrentTime);
    send(&d, "XdndEnter", 5L << 24, (long)d.list, 0, 0);
    send(&d, "XdndPosition", 0, 100L << 16 | 100, CurrentTime, (long)atom(&d, "XdndActionCopy"));
    int taken = wait_for(&d, "XdndStatus");
    if (taken) {
        send(&d, "XdndDrop", 0, CurrentTime, 0, 0);
        taken = wait_for(&d, "XdndFinished");
    }
    XCloseDisplay(d.display);
    return taken ? 0 : 1;
}
