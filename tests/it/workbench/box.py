"""Makes box.ttf, in which every character is the same box, and blanks are blank: `pip install fonttools`, then `python box.py`."""

import pathlib

from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen
from fontTools.ttLib.tables._c_m_a_p import CmapSubtable

# Thousandths of the size of the letters.
WIDE, HIGH, BLANK, BETWEEN = 550, 600, 300, 50
BLANKS = (0x20, 0xA0, 0x2009, 0x202F)


def glyph(wide):
    pen = TTGlyphPen(None)
    if wide:
        pen.moveTo((BETWEEN, 0))
        for corner in [(BETWEEN, HIGH), (wide - BETWEEN, HIGH), (wide - BETWEEN, 0)]:
            pen.lineTo(corner)
        pen.closePath()
    return pen.glyph()


def table(form, encoding, characters):
    made = CmapSubtable.newSubtable(form)
    made.platformID, made.platEncID, made.format, made.reserved, made.length, made.language = 3, encoding, form, 0, 0, 0
    made.cmap = {c: "space" if c in BLANKS else "box" for c in characters}
    return made


font = FontBuilder(1000, isTTF=True)
font.setupGlyphOrder([".notdef", "space", "box"])
font.setupCharacterMap({})
font.setupGlyf({".notdef": glyph(WIDE), "space": glyph(0), "box": glyph(WIDE)})
font.setupHorizontalMetrics({".notdef": (WIDE, BETWEEN), "space": (BLANK, 0), "box": (WIDE, BETWEEN)})
font.setupHorizontalHeader(ascent=800, descent=-200)
font.setupNameTable({"familyName": "Box", "styleName": "Regular", "psName": "Box", "version": "1"})
font.setupOS2(sTypoAscender=800, sTypoDescender=-200, usWinAscent=800, usWinDescent=200, sxHeight=500, sCapHeight=HIGH)
font.setupPost(keepGlyphNames=False)
# All characters at once are of format 13, which is read beside one of format 4 alone.
font.font["cmap"].tables = [table(4, 1, [0x20, 0x21]), table(13, 10, range(0x20, 0x30000))]
font.font["head"].created = font.font["head"].modified = 0
font.font.recalcTimestamp = False
font.save(pathlib.Path(__file__).with_name("box.ttf"))
