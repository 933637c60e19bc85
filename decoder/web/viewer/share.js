/* A link of the view, and a picture of it.
 *
 * SPDX-License-Identifier: MIT
 */
import { hashOf } from './state.js';

const byId = (id) => document.getElementById(id);

/**
 * Copies a link of the state, or shows it where the browser does not let the page copy.
 * @param inPage whether the material is one of those in the page, not a file of the user's
 * @returns what to tell the user
 */
export async function copyLink(state, inPage) {
    const hash = hashOf(state);
    const link = `${location.href.split('#')[0]}${hash ? `#${hash}` : ''}`;
    const own = [inPage ? '' : 'material', state.environment === 'own' ? 'environment' : ''].filter(Boolean).join(' and ');
    const warning = own ? ` Your own ${own} is not in it: send the file as well.` : '';
    byId('link').value = link;
    try {
        await navigator.clipboard.writeText(link);
        return `Copied the link.${warning}`;
    } catch {
        byId('link-shown').hidden = false;
        byId('link').focus();
        byId('link').select();
        return `The link is below, to be copied.${warning}`;
    }
}

/** Downloads the picture as PNG. @returns the file's name */
export async function savePicture(stage, canvas, title) {
    const blob = await stage.withPicture(() => new Promise((resolve) => { canvas.toBlob(resolve, 'image/png'); }));
    if (!blob) {
        throw new Error('the browser could not make a PNG of it');
    }
    const name = `${title.replace(/[^\w.-]+/g, '-').toLowerCase() || 'material'}.png`;
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    return name;
}
