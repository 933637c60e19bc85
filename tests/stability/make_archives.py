"""Writes odd, broken and malicious archives of a folder's images: make_archives.py IMAGES OUT.

SPDX-License-Identifier: MIT
"""
import io
import os
import struct
import sys
import tarfile
import zipfile
import zlib


def files_of(folder):
    found = []
    for where, _, names in os.walk(folder):
        for name in sorted(names):
            path = os.path.join(where, name)
            with open(path, 'rb') as file:
                found.append((os.path.relpath(path, folder), file.read()))
    return sorted(found)


def write_zip(path, entries, method=zipfile.ZIP_DEFLATED):
    with zipfile.ZipFile(path, 'w', method) as archive:
        for name, data in entries:
            archive.writestr(zipfile.ZipInfo(name), data, method)


def patch(path, change):
    with open(path, 'rb') as file:
        data = bytearray(file.read())
    change(data)
    with open(path, 'wb') as file:
        file.write(data)


def headers(data, magic):
    at = data.find(magic)
    while at >= 0:
        yield at
        at = data.find(magic, at + 4)


def encrypt(data):
    """Sets the flag "encrypted" of every entry."""
    for at in headers(data, b'PK\3\4'):
        data[at + 6] |= 1
    for at in headers(data, b'PK\1\2'):
        data[at + 8] |= 1


def declare(size):
    """Makes every entry claim that many bytes, compressed as they are."""
    def change(data):
        for at in headers(data, b'PK\3\4'):
            data[at + 22:at + 26] = struct.pack('<I', size)
        for at in headers(data, b'PK\1\2'):
            data[at + 24:at + 28] = struct.pack('<I', size)
    return change


def bomb(path, name, mebibytes):
    """A zip bomb: one entry of `mebibytes` MiB of zeros, made of one deflated block of 1 MiB, repeated."""
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    block = deflate.compress(bytes(1 << 20)) + deflate.flush(zlib.Z_FULL_FLUSH)
    stream = block * mebibytes + b'\3\0'
    size, raw = mebibytes << 20, name.encode()
    local = struct.pack('<4s5H3I2H', b'PK\3\4', 20, 0, 8, 0, 0x21, 0, len(stream), size & 0xFFFFFFFF, len(raw), 0) + raw
    central = struct.pack('<4s6H3I5H2I', b'PK\1\2', 20, 20, 0, 8, 0, 0x21, 0, len(stream), size & 0xFFFFFFFF, len(raw),
                          0, 0, 0, 0, 0, 0) + raw
    end = struct.pack('<4s4H2IH', b'PK\5\6', 0, 0, 1, 1, len(central), len(local) + len(stream), 0)
    with open(path, 'wb') as file:
        file.write(local + stream + central + end)
    return len(local + stream + central + end)


def write_tar(path, entries, extra=()):
    with tarfile.open(path, 'w') as archive:
        for info in extra:
            archive.addfile(info)
        for name, data in entries:
            info = tarfile.TarInfo(name)
            info.size = len(data)
            archive.addfile(info, io.BytesIO(data))


def special(name, kind, target=''):
    info = tarfile.TarInfo(name)
    info.type, info.linkname = kind, target
    info.devmajor, info.devminor = 1, 3
    return info


def main():
    source, out = sys.argv[1:]
    images = files_of(source)
    os.makedirs(out, exist_ok=True)

    def path(name):
        return os.path.join(out, name)

    write_zip(path('plain.zip'), images)
    write_zip(path('absolute.zip'), [(os.path.abspath('landed') + '/' + name, data) for name, data in images])
    write_zip(path('dots.zip'), [('../../../' + name, data) for name, data in images])
    write_zip(path('utf8.zip'), [('caf\u00e9 \u7d39/' + name, data) for name, data in images])
    write_zip(path('latin.zip'), [('cafe/' + name, data) for name, data in images])
    patch(path('latin.zip'), lambda data: data.__setitem__(slice(None), data.replace(b'cafe/', b'caf\xe9/')))
    write_tar(path('utf8.tar'), [('caf\u00e9 \u7d39/' + name, data) for name, data in images])
    write_zip(path('many.zip'), images + [(f'notes/{i}.txt', b'') for i in range(100000)], zipfile.ZIP_STORED)
    write_zip(path('nested.zip'), [('inner.zip', open(path('plain.zip'), 'rb').read())])
    write_zip(path('encrypted.zip'), images)
    patch(path('encrypted.zip'), encrypt)
    write_zip(path('declares-4g.zip'), images)
    patch(path('declares-4g.zip'), declare(0xFFFFFFF0))
    write_zip(path('declares-0.zip'), images)
    patch(path('declares-0.zip'), declare(0))
    write_zip(path('stored-lie.zip'), images, zipfile.ZIP_STORED)
    patch(path('stored-lie.zip'), declare(0x20000000))
    print(bomb(path('bomb.zip'), images[0][0], 1100))
    print(bomb(path('bomb-4g.zip'), images[0][0], 4097))
    write_tar(path('links.tar'), images, [special('a tl000 pl000 tv000 pv000.png', tarfile.SYMTYPE, '/etc/passwd'),
                                         special('b tl000 pl000 tv000 pv000.png', tarfile.LNKTYPE, images[0][0]),
                                         special('c tl000 pl000 tv000 pv000.png', tarfile.CHRTYPE),
                                         special('d tl000 pl000 tv000 pv000.png', tarfile.FIFOTYPE),
                                         special('e tl000 pl000 tv000 pv000.png', tarfile.BLKTYPE),
                                         special('tl000 pl000 tv000 pv000.png', tarfile.DIRTYPE)])
    write_tar(path('dots.tar'), [('../../' + name, data) for name, data in images])
    write_zip(path('long.zip'), images + [('x' * 60000 + '.png', b'')])
    write_zip(path('twice.zip'), images + [images[3]])
    write_zip(path('empty.zip'), [])


main()
