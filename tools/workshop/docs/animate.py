#!/usr/bin/env python3
"""The README's animation, of the stills that make_picture.mjs saves with "frames".

    python3 tools/workshop/docs/animate.py FOLDER docs/liver.webp

Needs Pillow with WebP.
"""
import glob
import sys

from PIL import Image

WIDTH, FRAME_MS = 760, 90

if len(sys.argv) != 3:
    sys.exit(__doc__)
frames = [Image.open(name).convert("RGB") for name in sorted(glob.glob(f"{sys.argv[1]}/*.png"))]
size = WIDTH, round(WIDTH * frames[0].height / frames[0].width)
frames = [frame.resize(size, Image.Resampling.LANCZOS) for frame in frames]
frames[0].save(sys.argv[2], save_all=True, append_images=frames[1:], duration=FRAME_MS, loop=0, quality=60,
               method=6)
