"""The script `run`: build folders that came with a copied source tree."""

import os
import pathlib
import shutil
import subprocess

from in_folder import InFolder

ROOT = pathlib.Path(__file__).resolve().parents[2]


class CopiedTree(InFolder):
    def setUp(self):
        super().setUp()
        shutil.copy(ROOT / "run", self.folder)
        # In place of the system's: every package is installed, and CMake reports that it was called.
        for name, output in (("dpkg-query", "installed"), ("cmake", "cmake was called")):
            self.write(f"bin/{name}", f"#!/bin/sh\nprintf '{output}'\n")
            os.chmod(os.path.join(self.folder, "bin", name), 0o755)

    def build(self, source):
        """Runs `./run build` with a CMake cache in build/release that names a source tree; None: no cache."""
        if source is not None:
            self.write("build/release/CMakeCache.txt", f"CMAKE_GENERATOR:INTERNAL=Ninja\nCMAKE_HOME_DIRECTORY:INTERNAL={source}\n")
        path = os.pathsep.join([os.path.join(self.folder, "bin"), os.environ["PATH"]])
        return subprocess.run(["bash", "run", "build"], cwd=self.folder, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False)

    def test_a_build_folder_of_another_tree_is_refused_with_the_command_that_removes_it(self):
        done = self.build("/somewhere/else")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("build/release was made for the source tree /somewhere/else", done.stderr)
        self.assertIn(f"rm -r '{os.path.realpath(self.folder)}/build/release'", done.stderr)
        self.assertNotIn("cmake was called", done.stdout)

    def test_the_tree_s_own_build_folder_is_used_and_a_missing_one_is_made(self):
        for source in (None, self.folder):
            done = self.build(source)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("cmake was called", done.stdout)
