#!/usr/bin/env bash
# test_in_blender.sh VENV [PYTEST ARGUMENT]...
# Builds the zip, installs it in a real Blender with settings of its own, and runs the tests there against
# what was installed. The Blender is $BLENDER, else the one on the PATH if it is 4.2 or newer, else fetched.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=$1; shift
python=$venv/bin/python build=$PWD/build/blender

usable() { "$1" -b --factory-startup --python-exit-code 1 \
  --python-expr 'import bpy; assert bpy.app.version >= (4, 2, 0)' >/dev/null 2>&1; }

blender=${BLENDER:-}
if [ -z "$blender" ]; then
  blender=$(command -v blender) && usable "$blender" || blender=$(tools/get_blender.sh)
fi
usable "$blender" || { echo "$blender is no Blender 4.2 or newer that starts" >&2; exit 1; }
version=$("$blender" -b --factory-startup --python-expr \
  'import sys; print("PYTHON=%d.%d" % sys.version_info[:2])' 2>/dev/null | sed -n 's/^PYTHON=//p')
echo "$("$blender" -b --version 2>/dev/null | grep -m1 '^Blender') with Python $version: $blender"

case $(uname -sm) in
  "Linux x86_64") platform=linux-x64;;
  "Darwin arm64") platform=macos-arm64;;
  *) echo "no zip is made for $(uname -sm)" >&2; exit 1;;
esac
# The release's own wheels wherever they fit this Blender's Python.
case $version in 3.11|3.13) wheels=();; *) wheels=(--python "$version");; esac
"$python" tools/build_zip.py --platform $platform "${wheels[@]}" --output "$build/zip" --blender "$blender"

# pytest has its own folder: nothing of the venv may be importable, lest it hide a wheel that the zip lacks.
pytest=$build/pytest-$version
[ -e "$pytest" ] || "$python" -m pip install --quiet --disable-pip-version-check --only-binary=:all: \
  --python-version "$version" --target "$pytest" "$(grep '^pytest==' tools/requirements.txt)"

# Where another Mesa than this Blender's shares the cache of shaders, each cuts the index to its own size under the
# other, which ends in a bus error.
export MESA_SHADER_CACHE_DIR=$build/mesa
export BLENDER_USER_RESOURCES=$build/user
rm -rf "$BLENDER_USER_RESOURCES"; mkdir -p "$BLENDER_USER_RESOURCES"
"$blender" -b --command extension install-file -r user_default -e "$build"/zip/*.zip
"$blender" -b --python-exit-code 1 --python tests/run_in_blender.py -- "$pytest" "$@"
