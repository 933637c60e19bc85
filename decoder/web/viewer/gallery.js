/* The gallery: cards over the picture, links to the same page with another material behind #.
 *
 * SPDX-License-Identifier: MIT
 */
const byId = (id) => document.getElementById(id);

function show(open) {
    const gallery = byId('gallery');
    if (gallery.hidden === open) {
        gallery.hidden = !open;
        document.querySelector('main').inert = document.querySelector('header').inert = open;
        (open ? gallery.querySelector('a') : byId('gallery-open')).focus();
    }
}

/** Listens on the gallery, where the page has one; it is open where the link asks for nothing. */
export function listenGallery() {
    const gallery = byId('gallery');
    if (!gallery) {
        return;
    }
    byId('gallery-open').addEventListener('click', () => show(true));
    byId('gallery-close').addEventListener('click', () => show(false));
    gallery.addEventListener('click', (event) => {
        if (event.target.closest('a')) {
            show(false); // the link itself is followed
        }
    });
    gallery.addEventListener('keydown', (event) => {
        if (event.key === 'Escape') {
            show(false);
        }
    });
    addEventListener('hashchange', () => show(false));
    if (location.hash.length < 2) {
        show(true);
    }
}
