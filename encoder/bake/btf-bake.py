#!/usr/bin/env python3
"""btf-bake: renders a scene of Blender from every view under every light, as a data set for btf-encode.

The driver: reads the command line, starts Blender once with btf_bake.py, shows progress, and goes on to btf-encode. Runs
by any Python from 3.7 on, without Blender's modules.

SPDX-License-Identifier: MIT
"""
import argparse
import dataclasses
import glob
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.realpath(__file__))
INSTALLED = '@modules@'  # meson puts in the path from the installed tool's folder to that of the modules
VERSION = '@version@'  # meson puts in the version
MODULES = HERE if os.path.exists(os.path.join(HERE, 'btf_bake.py')) else os.path.normpath(os.path.join(HERE, INSTALLED))
sys.path.insert(0, MODULES)
sys.dont_write_bytecode = True

from bake_settings import BAD_FILE, INTERNAL, INTERRUPTED, IO, UNSUPPORTED, USAGE, BakeError, Settings  # noqa: E402

OLDEST = (3, 0)
SUMMARY = """\
Renders what a scene of Blender has in its collection BTF from every view under every light, by Cycles on the CPU, and
writes the images as a data set that btf-encode reads: float OpenEXR, linear, in the layout of UBO2003. The same command
goes on after an interruption or a kill."""
DETAILS = """\
Axes: the tile's x is +u (columns), its y is +v (up), z the normal; theta from z, phi from x towards y.
Values: radiance x pi / irradiance of the light at normal incidence, so that a white plane gives cos(theta).
Directions: ubo (81), ubo2014 (151), small (19), tiny (5), a number of 1..256 on a spiral, rings
THETA:COUNT[:OFFSET],..., or a text file with theta and phi a line.

Exit codes:
    0  ok
    1  invalid argument
    2  input or output failed
    3  bad file: Blender cannot read it, or there is nothing in it that can be baked
    4  internal error, out of memory, Blender crashed
    5  not supported: no Blender, or one before 3.0
  130  interrupted
With --encode, those of btf-encode from there on.

Example:
  btf-bake knit.blend --preview knit.png
  btf-bake knit.blend -o knit --texels 64 --samples 16 --encode knit.btf.exr -- --budget 2MB
  btf-bake knit.blend -o knit --part 2/4      # on the second of four machines that share a folder
  btf-bake knit.blend -o tiny --texels 32x16 --directions small --views 0:1,45:8 --position tiny-position"""


class Parser(argparse.ArgumentParser):
    def format_help(self): # begins as the help of the other tools does
        return super().format_help().replace('usage: ', 'Usage: ', 1)

    def error(self, message):
        fail(USAGE, message + ' (btf-bake --help)')


def say(kind, text):
    if sys.stderr.isatty():
        sys.stderr.write('\r\033[K')
    safe = ''.join(c if c.isprintable() or c == '\n' else f'\\x{ord(c):02x}' for c in text)
    sys.stderr.write(f'btf-bake: {kind}{safe}\n')
    sys.stderr.flush()


def fail(code, text):
    say('error: ', text)
    sys.exit(code)


def parse_texels(text):
    match = re.fullmatch(r'(\d{1,5})(?:x(\d{1,5}))?', text)
    if not match:
        raise argparse.ArgumentTypeError(f"'{text}' is neither N nor WIDTHxHEIGHT")
    return int(match[1]), int(match[2] or match[1])


def parse_tile(text):
    try:
        numbers = tuple(float(field) for field in text.split(','))
    except ValueError:
        numbers = ()
    if len(numbers) != 4:
        raise argparse.ArgumentTypeError(f"'{text}' is not x,y,width,height")
    return numbers


def parse_part(text):
    match = re.fullmatch(r'(\d{1,6})/(\d{1,6})', text)
    if not match:
        raise argparse.ArgumentTypeError(f"'{text}' is not I/N, such as 2/4")
    return int(match[1]), int(match[2])


def command_line():
    default = Settings()
    parser = Parser(prog='btf-bake', usage='btf-bake SCENE.blend -o DIR [options] [--encode OUT.btf.exr [-- OPTIONS]]',
                    description=SUMMARY, epilog=DETAILS, allow_abbrev=False, add_help=False,
                    formatter_class=lambda prog: argparse.RawDescriptionHelpFormatter(prog, max_help_position=28, width=110))
    add = parser.add_argument
    add('scene', metavar='SCENE.blend', help=argparse.SUPPRESS)
    what = parser.add_argument_group('What is baked')
    what.add_argument('--collection', metavar='NAME', help="the objects in this collection (default 'BTF')")
    what.add_argument('--object', metavar='NAME', action='append', dest='objects', help='this object instead; may be repeated')
    what.add_argument('--tile', metavar='X,Y,W,H', type=parse_tile,
                      help='low corner, width and height of the tile (default 0,0,1,1)')
    what.add_argument('--z', metavar='Z', type=float, help='height of the reference plane, the top of the surface (default 0)')
    what.add_argument('--no-repeat', action='store_false', dest='repeat', default=None,
                      help='no copies of the tile around it: the scene has its neighbours')
    what.add_argument('--frame', metavar='N', type=int, help='of an animation (default: as saved)')
    what.add_argument('--strict', action='store_true', default=None, help='warnings about the scene are errors')
    how = parser.add_argument_group('How')
    how.add_argument('--directions', metavar='LIST', help='views and lights, see below (default ubo)')
    how.add_argument('--views', metavar='LIST', help='views, where they differ')
    how.add_argument('--lights', metavar='LIST', help='lights, where they differ')
    how.add_argument('--pairs', metavar='FILE', help='instead of a grid: theta and phi of the view, theta and phi of the light '
                     'a line, as btf-sample --pairs')
    how.add_argument('--texels', metavar='N|WxH', type=parse_texels, help='columns and rows (default 64)')
    how.add_argument('--samples', metavar='N', type=int, help=f'paths a texel and image (default {default.samples})')
    how.add_argument('--bounces', metavar='N', type=int,
                     help=f'indirect reflections; 0: direct light alone (default {default.bounces})')
    how.add_argument('--sun-angle', metavar='DEGREES', type=float,
                     help=f'angular diameter of the light (default {default.sun_angle:g})')
    how.add_argument('--seed', metavar='N', type=int, help='another seed, other noise (default 0)')
    how.add_argument('--part', metavar='I/N', type=parse_part,
                     help='of every N images the I-th: N processes or machines share the work')
    how.add_argument('--threads', metavar='N', type=int, help='threads (default: all cores)')
    how.add_argument('--blender', metavar='PROGRAM', default='blender', help='Blender, 3.0 or later (default: that on the PATH)')
    out = parser.add_argument_group('Output')
    out.add_argument('-o', '--output', metavar='DIR', help='folder of the images, made if need be')
    out.add_argument('--position', metavar='DIR', help='also where each texel looks, an OpenEXR file a view: R, G, B are x, y '
                     'from the low corner of the tile and z from the reference plane')
    out.add_argument('--preview', metavar='FILE.png', help='instead: 3 views and 4 lights side by side, in seconds')
    out.add_argument('--encode', metavar='OUT.btf.exr', help='then encode; options of btf-encode behind --')
    out.add_argument('-q', '--quiet', action='store_true', help='no progress, no summary')
    out.add_argument('-h', '--help', action='help', help='print this help and exit')
    version = VERSION if VERSION[0].isdigit() else 'of a source folder'
    out.add_argument('--version', action='version', version=f'btf-bake (OpenBTF) {version}', help='print the version and exit')
    arguments, more = sys.argv[1:], []
    if '--tile' in arguments[:-1]:  # its numbers may begin with a minus, which argparse would take for an option
        at = arguments.index('--tile')
        arguments[at:at + 2] = ['--tile=' + arguments[at + 1]]
    if '--' in arguments:
        at = arguments.index('--')
        arguments, more = arguments[:at], arguments[at + 1:]
    return parser.parse_args(arguments), more


def settings_of(options, more):
    """Checked Settings of a command line. Raises BakeError."""
    given = {field.name: getattr(options, field.name) for field in dataclasses.fields(Settings)
             if getattr(options, field.name, None) is not None}
    settings = Settings(**given)
    if more and not options.encode:
        raise BakeError(USAGE, f"options behind -- are btf-encode's, which runs with --encode OUT.btf.exr: {' '.join(more)}")
    if options.encode and not options.output:
        raise BakeError(USAGE, '--encode needs -o DIR for the images')
    if options.encode and not options.encode.lower().endswith('.btf.exr'):
        raise BakeError(USAGE, f"--encode: '{options.encode}' does not end in .btf.exr")
    if options.encode and settings.pairs:
        raise BakeError(USAGE, '--pairs: images between the samples are for btf-compare, and not encoded')
    if settings.preview and (settings.output or settings.position):
        raise BakeError(USAGE, '--preview stands alone, without -o and --position')
    if settings.preview and not settings.preview.lower().endswith('.png'):
        raise BakeError(USAGE, f"--preview: '{settings.preview}' does not end in .png")
    for name in ('output', 'position', 'preview', 'pairs'):
        if getattr(settings, name):
            setattr(settings, name, os.path.abspath(getattr(settings, name)))
    settings.check()
    settings.images()
    return settings


def check_scene(path):
    """Raises BakeError where the file is not a Blender file."""
    try:
        with open(path, 'rb') as file:
            first = file.read(7)
    except OSError as error:
        raise BakeError(IO, f'{path}: {error.strerror}') from None
    if not (first == b'BLENDER' or first[:2] == b'\x1f\x8b' or first[:4] == b'\x28\xb5\x2f\xfd'):
        raise BakeError(BAD_FILE, f'{path}: not a file of Blender')


def find_blender(name):
    """Path of a Blender that can be used. Raises BakeError."""
    path = shutil.which(name)
    if not path:
        raise BakeError(UNSUPPORTED, f"'{name}': there is no such program; install Debian's package blender, or name another "
                        'by --blender')
    try:
        text = subprocess.run([path, '--version'], capture_output=True, text=True, timeout=120).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BakeError(UNSUPPORTED, f'{path} --version: {error}') from None
    match = re.search(r'^Blender (\d+)\.(\d+)', text, re.M)
    if not match:
        raise BakeError(UNSUPPORTED, f'{path}: does not say which version of Blender it is')
    if (int(match[1]), int(match[2])) < OLDEST:
        raise BakeError(UNSUPPORTED, f'{path}: Blender {match[1]}.{match[2]}, and 3.0 is the oldest that can be used')
    return path


class Shown:
    """Progress on stderr: a bar on a terminal, a line each tenth in a log."""

    def __init__(self, quiet):
        self.quiet, self.tty, self.stage, self.tenth, self.start = quiet, sys.stderr.isatty(), None, -1, 0.0

    def show(self, stage, done, total, left):
        if self.quiet or total == 0:
            return
        if stage != self.stage:
            self.stage, self.tenth, self.start = stage, 10 * done // total, time.monotonic()
        left = '' if left < 0 else f'{duration(left)} left'
        if self.tty:
            full = 24 * done // total
            sys.stderr.write(f'\r\033[K{stage:<17} [{"#" * full}{"." * (24 - full)}] {100 * done // total:3d}%  {left}\r')
        elif 10 * done // total > self.tenth:
            self.tenth = 10 * done // total
            sys.stderr.write(f'{stage}: {100 * done // total}%{", " + left if left and done < total else ""}\n')
        if done == total:
            if self.tty:
                sys.stderr.write('\r\033[K')
            sys.stderr.write(f'{stage}: done after {time.monotonic() - self.start:.1f} s\n')
        sys.stderr.flush()


def duration(seconds):
    s = int(seconds + 0.5)
    return f'{s // 3600}:{s // 60 % 60:02d}:{s % 60:02d}' if s >= 3600 else f'{s // 60}:{s % 60:02d}'


class Stop(Exception):
    pass


def on_signal(*_):
    raise Stop


def end_child(child):
    """Ends Blender, and waits for it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    child.terminate()
    try:
        child.wait(10)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()


def environment(blender, scratch):
    """Gives the environment that Blender runs in. A Blender without a Python of its own, such as Debian's, takes the modules
    of the first python3 on the PATH: that should be the one beside it."""
    path = os.pathsep.join([os.path.dirname(os.path.abspath(blender)), '/usr/bin', os.environ.get('PATH', os.defpath)])
    return {**os.environ, 'PATH': path, 'TMPDIR': scratch, 'PYTHONDONTWRITEBYTECODE': '1'}


def bake(blender, scene, settings, quiet):
    """Runs Blender. Returns what it says at the end; raises BakeError, Stop."""
    end, shown = None, Shown(quiet)
    with tempfile.TemporaryDirectory(prefix='btf-bake-') as scratch:
        asked, log = os.path.join(scratch, 'settings.json'), os.path.join(scratch, 'log.txt')
        with open(asked, 'w', encoding='utf-8') as file:
            json.dump(dataclasses.asdict(settings), file)
        reader, writer = os.pipe()
        # Blender ignores the user's settings, on which the images would depend, and runs no scripts of the file, which
        # could do anything.
        command = [blender, '--background', '--factory-startup', '--disable-autoexec', '-noaudio', os.path.abspath(scene),
                   '--python', os.path.join(MODULES, 'btf_bake.py'), '--', asked, os.path.abspath(scene), str(writer)]
        with open(log, 'wb') as output:
            # Blender runs in a session of its own, so that Ctrl-C reaches the driver alone, which then ends Blender.
            child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, pass_fds=[writer],
                                     start_new_session=True, env=environment(blender, scratch))
        os.close(writer)
        try:
            with os.fdopen(reader, encoding='utf-8') as reports:
                for line in reports:
                    message = json.loads(line)
                    kind = message.pop('kind')
                    if kind == 'progress':
                        shown.show(**message)
                    elif kind in ('end', 'error'):
                        end = kind, message
                    elif kind == 'warning' or not quiet:
                        say('warning: ' if kind == 'warning' else '', message['text'])
            child.wait()
        finally:
            if child.poll() is None:
                end_child(child)
            for folder in (settings.output, settings.position):
                beside = os.path.join(glob.escape(folder), f'.bake-{glob.escape(socket.gethostname())}-{child.pid}-*')
                for path in glob.glob(beside) if folder else ():
                    os.remove(path)
        if end is None:
            with open(log, encoding='utf-8', errors='replace') as file:
                lines = file.readlines()
            unread = [line.strip() for line in lines if re.match('Error: (Failed to read|Cannot read)', line)]
            if unread:
                raise BakeError(BAD_FILE, f'{scene}: Blender cannot read it: {unread[0]}')
            last = ''.join(lines[-15:])
            raise BakeError(INTERNAL, f'Blender ended with {child.returncode} before the bake did; its last lines:\n{last}')
    if end[0] == 'error':
        raise BakeError(end[1]['code'], end[1]['text'])
    return end[1]


def encode(options, settings, more):
    """Goes on to btf-encode, and returns its exit code."""
    beside = os.path.join(HERE, 'btf-encode')
    program = beside if os.path.exists(beside) else shutil.which('btf-encode')
    if not program:
        raise BakeError(IO, f'btf-encode is neither beside {sys.argv[0]} nor on the PATH')
    command = [program, settings.output, '-o', options.encode, *(['-q'] if options.quiet else []), *more]
    child = subprocess.Popen(command)
    try:
        return child.wait()
    except Stop:
        end_child(child)
        return INTERRUPTED


def main():
    options, more = command_line()
    signal.signal(signal.SIGINT, on_signal)
    signal.signal(signal.SIGTERM, on_signal)
    try:
        settings = settings_of(options, more)
        check_scene(options.scene)
        end = bake(find_blender(options.blender), options.scene, settings, options.quiet)
        if settings.output and not options.quiet:
            say('', f"{settings.output}: {end['images']} images"
                + (f" of part {settings.part[0]}/{settings.part[1]}" if settings.part[1] > 1 else '')
                + f", {end['rendered']} of them rendered in {end['seconds']:.1f} s"
                + (f"; {end['missing']} of the other parts are missing" if end['missing'] else ''))
        if options.encode and end['missing']:
            raise BakeError(IO, f"{settings.output}: {end['missing']} images of the other parts are missing: not encoded")
        code = encode(options, settings, more) if options.encode else 0
    except BakeError as error:
        fail(error.code, str(error))
    except Stop:
        fail(INTERRUPTED, 'interrupted' + (': the same command goes on' if options.output else ''))
    sys.exit(code)


if __name__ == '__main__':
    main()
