"""Lists of directions, as btf-sample takes them, and the names of the images that show them.

Plain Python without bpy: the driver checks a list before Blender is started. A direction is a pair (theta, phi) in
degrees: theta from the normal, phi from +x (+u) towards +y (+v), decoder/FORMAT.md, section 1. Angles are rounded to
1e-4 degrees, which is what file names hold.

SPDX-License-Identifier: MIT
"""
import math
import os

MOST = 256  # the most views, or lights, that a data set may have (encoder/INPUTS.md)
STEEPEST = 85.0

RINGS = {
    'ubo': '0:1,15:6,30:12,45:18,60:20,75:24',
    'ubo2014': '0:1,11:6:15,23.5:12,30:12:15,37.5:12,45:18,52.5:18:7.5,60:24,67.5:24:7.5,75:24',
    'small': '0:1,30:6,60:12',
    'tiny': '0:1,45:4',
}
EXPECTED = 'ubo, ubo2014, small, tiny, a number of 1..256, rings such as 0:1,30:6,60:12, or a text file'


def _rounded(degrees):
    return round(degrees * 1e4) / 1e4


def _turned(degrees):
    """The azimuth brought into 0 to 360 degrees and rounded."""
    phi = _rounded(degrees % 360)
    return phi if phi < 360 else 0.0


def _spiral(count):
    """A spiral: each direction stands for an equal area of the cap from the pole to 75 degrees, and is turned by the
    golden angle from the one before (H. Vogel, Mathematical Biosciences 44, 1979, here on the sphere)."""
    lowest, golden = math.cos(math.radians(75)), 180 * (3 - math.sqrt(5))
    found = []
    for i in range(count):
        theta = _rounded(math.degrees(math.acos(1 - (1 - lowest) * i / (count - 1) if count > 1 else 1)))
        found.append((theta, _turned(golden * i) if theta > 0 else 0.0))
    return found


def _ring(text):
    """The directions of THETA:COUNT[:OFFSET]; raises ValueError with what is wrong."""
    fields = text.split(':')
    if len(fields) not in (2, 3):
        raise ValueError(f"'{text}': expected THETA:COUNT or THETA:COUNT:OFFSET")
    try:
        theta, count = _rounded(float(fields[0])), int(fields[1])
        offset = float(fields[2]) if len(fields) == 3 else 0.0
    except ValueError:
        raise ValueError(f"'{text}': not numbers") from None
    if not 0 <= theta <= STEEPEST:
        raise ValueError(f'theta {fields[0]} is not in 0..85')
    if not 1 <= count <= MOST:
        raise ValueError(f'the ring at theta {fields[0]} has {count} directions, not 1..{MOST}')
    if theta == 0 and count != 1:
        raise ValueError('the ring at theta 0 has 1 direction')
    if not 0 <= offset < 360:
        raise ValueError(f'the azimuth offset {fields[2]} is not in 0..360')
    return [(theta, _turned(offset + 360 * i / count) if theta > 0 else 0.0) for i in range(count)]


def _rings(text):
    found, last = [], -1.0
    for part in text.split(','):
        ring = _ring(part)
        if ring[0][0] <= last:
            raise ValueError(f'theta {ring[0][0]:g} does not rise')
        last = ring[0][0]
        found += ring
    return found


def _lines(path):
    """Yields (line number, line, fields) of the lines of a text file that hold fields. Blanks or commas separate
    fields; # begins a comment."""
    with open(path, encoding='utf-8-sig') as file:
        for number, line in enumerate(file, 1):
            fields = line.split('#')[0].replace(',', ' ').split()
            if fields:
                yield number, line, fields


def _file(path):
    """The directions of a text file, one a line: theta and phi."""
    found = []
    for number, line, fields in _lines(path):
        try:
            theta, phi = map(float, fields)
        except ValueError:
            raise ValueError(f"{path}:{number}: '{line.strip()}' is not theta and phi") from None
        if not (0 <= theta <= STEEPEST and math.isfinite(phi)):
            raise ValueError(f'{path}:{number}: theta {theta:g} is not in 0..85, or phi {phi:g} is no angle')
        theta = _rounded(theta)
        found.append((theta, _turned(phi) if theta > 0 else 0.0))
    return found


def parse(text):
    """The directions of a list, in paper order: theta ascending, then phi.

    text: ubo (81), ubo2014 (151), small (19), tiny (5); a number of 1..256, a spiral; rings THETA:COUNT[:OFFSET],...; or
    the path of a text file, theta and phi a line. Raises ValueError with a message that names the value."""
    try:
        if text in RINGS:
            found = _rings(RINGS[text])
        elif text.isascii() and text.isdigit():
            if not 1 <= int(text) <= MOST:
                raise ValueError(f'{text} is not in 1..{MOST}')
            found = _spiral(int(text))
        elif os.path.isfile(text):
            found = _file(text)
        elif ':' in text:
            found = _rings(text)
        else:
            raise ValueError('there is neither a list nor a file of this name')
        if not 1 <= len(found) <= MOST:
            raise ValueError(f'{len(found)} directions, not 1..{MOST}')
        if len(set(found)) != len(found):
            raise ValueError('a direction stands there twice')
    except OSError as error:
        raise ValueError(f"directions '{text}': {error.strerror}") from None
    except (ValueError, UnicodeDecodeError) as error:
        raise ValueError(f"directions '{text}': {error} ({EXPECTED})") from None
    return sorted(found)


def pairs(path):
    """The pairs of a text file: theta and phi of the view, theta and phi of the light a line, as btf-sample --pairs
    reads them. Returns [((theta_v, phi_v), (theta_l, phi_l))] in the order of the file. Raises ValueError."""
    found = []
    try:
        for number, line, fields in _lines(path):
            try:
                angles = [float(field) for field in fields[-4:]]
            except ValueError:
                if not found and not any(c.isdigit() for c in line):
                    continue  # the first line may hold titles
                angles = []
            if len(angles) != 4 or len(fields) > 5 or not all(map(math.isfinite, angles)):
                raise ValueError(f"{path}:{number}: '{line.strip()}' is not theta and phi of the view and of the light")
            for theta in angles[::2]:
                if not 0 <= theta <= STEEPEST:
                    raise ValueError(f'{path}:{number}: theta {theta:g} is not in 0..85')
            found.append(tuple((_rounded(theta), _turned(phi) if theta > 0 else 0.0)
                               for theta, phi in zip(angles[::2], angles[1::2])))
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f'{path}: {getattr(error, "strerror", None) or error}') from None
    if not found:
        raise ValueError(f'{path}: no pairs')
    if len(set(found)) != len(found):
        raise ValueError(f'{path}: a pair stands there twice')
    return found


def vector(direction):
    """The unit vector (x, y, z) of (theta, phi)."""
    theta, phi = map(math.radians, direction)
    return math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)


def angle(degrees):
    """An angle as file names hold it: three digits, and four decimals where it is no whole number."""
    return f'{degrees:03.0f}' if abs(degrees - round(degrees)) < 5e-5 else f'{degrees:08.4f}'


def view_name(view):
    """tvTTT_pvPPP: the name of a view's folder and of its file of positions."""
    return f'tv{angle(view[0])}_pv{angle(view[1])}'


def image_name(view, light, number):
    """The path of an image within the data set, in the layout of UBO2003. number: n_views * light + view."""
    return (f'{view_name(view)}/{number:05d} tl{angle(light[0])} pl{angle(light[1])} '
            f'tv{angle(view[0])} pv{angle(view[1])}.exr')


def pair_name(view, light):
    """The name of the image of a pair between the samples, as btf-sample --pairs writes it."""
    return f'tl{light[0]:07.4f}_pl{light[1]:08.4f}_tv{view[0]:07.4f}_pv{view[1]:08.4f}.exr'
