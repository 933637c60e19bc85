"""A bake beside the window: another Blender renders the file, as btf-bake starts it, and this one stays usable.

SPDX-License-Identifier: MIT
"""
import dataclasses
import json
import os
import shutil
import subprocess
import tempfile

import bpy
import btf_bake


class Job:
    """One bake, and the encoding of its images where `encode` (a command) is given. Call poll() until `done`; then `error`
    is the message of what went wrong, or empty. close() ends what still runs: a later bake goes on with the images that
    are there."""

    def __init__(self, settings, encode=None):
        self.done, self.error, self.said, self.progress = False, '', 'starting', 0.0
        self._encode, self._rest, self._ended, self._pipe = encode, b'', False, None
        self._folder = tempfile.mkdtemp(prefix='btf-bake-')
        try:
            scene = bpy.data.filepath
            if bpy.data.is_dirty or not scene:
                # A preview shows the scene with its unsaved changes. Before a bake operators.py demands a saved file.
                scene = os.path.join(self._folder, 'scene.blend')
                bpy.ops.wm.save_as_mainfile(filepath=scene, copy=True, check_existing=False)
            asked = os.path.join(self._folder, 'settings.json')
            with open(asked, 'w', encoding='utf-8') as file:
                json.dump(dataclasses.asdict(settings), file)
            self._pipe, write = os.pipe()
            os.set_blocking(self._pipe, False)
            try:
                self._start([bpy.app.binary_path, '--background', '--factory-startup', '--disable-autoexec', '-noaudio', scene,
                             '--python', btf_bake.__file__, '--', asked, scene, str(write)], pass_fds=(write,),
                            # Scratch files go with the folder when the bake is stopped, as a killed Blender removes none.
                            env={**os.environ, 'TMPDIR': self._folder, 'PYTHONDONTWRITEBYTECODE': '1'})
            finally:
                os.close(write)
        except BaseException:
            self.close()
            raise

    def _start(self, command, **more):
        self._log = os.path.join(self._folder, 'log')
        with open(self._log, 'wb') as log:
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, **more)

    def _reports(self):
        """The reports that the other Blender sent since the last call."""
        while True:
            try:
                read = os.read(self._pipe, 65536)
            except BlockingIOError:
                break
            if not read:
                break
            self._rest += read
        *lines, self._rest = self._rest.split(b'\n')
        return [json.loads(line) for line in lines if line.strip()]

    def _take(self, report):
        kind = report.get('kind')
        if kind == 'progress':
            self.progress = report['done'] / max(report['total'], 1)
            left = report.get('left', -1)
            self.said = f"{report['stage']}: {report['done']} of {report['total']}"
            if left >= 0:
                self.said += f', {duration(left)} left'
        elif kind == 'warning':
            print('btf-bake: warning:', report['text'])
        elif kind == 'error':
            self.error = report['text']
        elif kind == 'end':
            self._ended = True

    def poll(self):
        """Takes in what the bake reported since the last call; returns True when something changed."""
        if self.done:
            return False
        before = self.said, self.progress
        code = self._process.poll()
        if self._pipe is not None:
            for report in self._reports():
                self._take(report)
        if code is None:
            return before != (self.said, self.progress)
        if self._pipe is not None:
            os.close(self._pipe)
            self._pipe = None
            if not self._ended and not self.error:
                self.error = f'Blender ended with code {code}: {self._last()}'
            if not self.error and self._encode:
                self.said = 'encoding'
                try:
                    self._start(self._encode)
                    return True
                except OSError as error:
                    self.error = f'{self._encode[0]}: {error.strerror}; where it is can be set in the panel below More'
        elif code:
            self.error = f'{self._encode[0]} ended with code {code}: {self._last()}'
        self.done = True
        return True

    def _last(self):
        with open(self._log, encoding='utf-8', errors='replace') as log:
            lines = [line.strip() for line in log if line.strip()]
        return lines[-1] if lines else 'it said nothing'

    def close(self):
        process = getattr(self, '_process', None)
        if process and process.poll() is None:
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        if self._pipe is not None:
            os.close(self._pipe)
            self._pipe = None
        self.done = True
        shutil.rmtree(self._folder, ignore_errors=True)


def duration(seconds):
    seconds = int(seconds + 0.5)
    return f'{seconds} s' if seconds < 120 else f'{seconds // 60} min' if seconds < 7200 else f'{seconds / 3600:.1f} h'
