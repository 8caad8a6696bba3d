"""The English words a prompt may be made of besides the names of styles; those of other languages stand for them in `languages`."""

from __future__ import annotations

from collections.abc import Mapping

from mechstyle.records.regions import ENDS


def _of(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())


SIZES: Mapping[str, float] = {
    "tiny": 0.5, "minute": 0.5, "miniature": 0.5, "micro": 0.5, "small": 0.7, "little": 0.7, "fine": 0.7, "dense": 0.7,
    "thin": 0.7, "tight": 0.8, "narrow": 0.8, "medium": 1.0, "wide": 1.25, "large": 1.4, "big": 1.4, "coarse": 1.4,
    "chunky": 1.4, "thick": 1.4, "bulky": 1.4, "huge": 2.0, "giant": 2.0, "massive": 2.0,
}  # fmt: skip
"""Factor on the size of features, by word."""
AMOUNTS: Mapping[str, float] = {
    "flat": 0.4, "faint": 0.4, "subtle": 0.5, "smooth": 0.5, "low": 0.6, "gentle": 0.6, "delicate": 0.6, "shallow": 0.6, "soft": 0.6,
    "mild": 0.6, "moderate": 1.0, "pronounced": 1.4, "rough": 1.4, "rugged": 1.5, "strong": 1.5, "bold": 1.5, "deep": 1.6,
    "heavy": 1.6, "dramatic": 1.8, "extreme": 2.0,
}  # fmt: skip
"""Factor on the height of the relief, by word."""
COLOURS: Mapping[str, str] = {
    "red": "b8322a", "crimson": "a31631", "scarlet": "c8271c", "maroon": "6b1f2a", "burgundy": "6d1a36", "ruby": "9b1b3b",
    "pink": "e58fb0", "rose": "d6708a", "rose_gold": "c98f83", "salmon": "e8907c", "peach": "f0b48e", "orange": "dd7a22",
    "amber": "d8922a", "terracotta": "bf6443", "rust": "9c4a22", "rusty": "9c4a22", "copper": "b46a3c", "bronze": "8a6236",
    "brass": "b5933f", "brown": "7a4f2e", "chocolate": "4e2f1d", "tan": "c4a27a", "beige": "d9c8a5", "khaki": "b3a36b", "sand": "d3ba8a",
    "cream": "efe3c4", "ivory": "efe9d6", "yellow": "e3bf34", "gold": "c99a2e", "golden": "c99a2e", "mustard": "c59a1f",
    "lime": "9ac43a", "lime_green": "9ac43a", "green": "4c8f3c", "forest_green": "2c5f34", "olive": "75782f", "olive_green": "75782f",
    "emerald": "1f8f5f", "jade": "4fa07a", "mint": "9ad4b4", "teal": "1f7f80", "petrol": "1d5b66", "turquoise": "3bb5b0", "aqua": "55c4c4",
    "cyan": "35b3c9", "blue": "2f5fa8", "sky_blue": "7db4e0",
    "baby_blue": "a9cdea", "ice_blue": "a9cdea", "royal_blue": "2a4fb4", "steel_blue": "4f7898",
    "navy": "1f2f5c", "navy_blue": "1f2f5c", "sapphire": "1f4694", "azure": "3f8fd0", "indigo": "3c3a86", "purple": "6f3f93",
    "violet": "7d55ad", "lilac": "b99ad0", "lavender": "b3a1d6", "plum": "6e3560", "magenta": "b8358a", "fuchsia": "c43d92",
    "white": "ebeae6", "off_white": "eae5d8", "silver": "b9bcc0", "chrome": "c6cace", "platinum": "cfcecb", "grey": "85868a",
    "gray": "85868a", "gunmetal": "50565c", "anthracite": "34363b", "charcoal": "3b3c40", "black": "262629", "mahogany": "5e2318",
}  # fmt: skip
"""Display RGB in hexadecimal digits, by word; "_" joins words that are a colour only together."""
FAMILIES = _of("red orange yellow green blue purple pink brown white grey gray black")
"""Colours that only say of what kind another one is that stands before them: emerald green."""
SHADES: Mapping[str, float] = {
    "dark": 0.55, "deep": 0.7, "bright": 1.2, "vivid": 1.2, "light": 1.45, "pale": 1.6, "pastel": 1.6,
}  # fmt: skip
"""How light a colour is to be, by word: below 1 darker by scaling, above 1 mixed with white."""
DEGREES: Mapping[str, float] = {
    "very": 1.6, "extremely": 2.0, "really": 1.6, "super": 1.8, "slightly": 0.5, "somewhat": 0.6, "quite": 1.2, "more": 1.0,
    "much": 1.6, "less": -0.5,
}  # fmt: skip
"""Power of the factor of the word that follows, by word."""
FILLERS = _of("""
    a an the of in on from to for by as is are be it its this that these those my your our all over into out at made make turn like look
    looks looking style styled stylized stylised texture textures textured pattern patterns patterned surface finish effect covered
    coated built layer rendering rendered render 3d image photo art model object thing part unreal engine please some coloured colored
    colour color wall walls colourful colorful i me we you want would should could can need give have has having get use using only just
    which ones so too then there here half side area region zone section material inspired themed theme design decor decorated
    decoration ornament kind sort type size sized high tall long height diameter spacing every each instead rather crest peak
    highlight leave keep put add paint draw two both feature first touch change anything was were been cup mug vase bowl pot planter
    lamp lampshade holder pen phone stand case tray bracket toy figure x z s t d ll w about approximately around circa ca
    board else
    """)
"""Words that ask for nothing."""
PICTURES = _of("picture image photo logo")
"""What a picture of the user's is called, where there is one."""
NEGATIONS = _of("not no without never except excluding minus instead_of rather_than anything_but everything_but all_but other_than"
                " apart_from aside_from dont do_not isnt avoid nothing nor neither everywhere_but but_not")  # fmt: skip
"""What stands after one of them, up to a comma or a word of SEPARATORS, is not wanted."""
NEGATED_BEFORE = "not_before"
"""The same of what stands before it; only other languages have such a word."""
SEPARATORS = _of(", and with but while plus")
"""Between two of them may stand another place with a style of its own."""
PLAIN = _of("plain bare untouched alone unstyled unstylised unstylized blank undecorated")
"""As the part is, without relief …"""
SMOOTH = _of("smooth flat")
"""… and what says so of a place that is given no style."""
EVERYWHERE = _of("everywhere everything rest elsewhere remainder otherwise whole entire body")
"""All of the part that is not spoken of elsewhere."""
PLACES: Mapping[str, str] = {
    "outside": "outside", "outer": "outside", "exterior": "outside", "outsides": "outside", "inside": "inside", "inner": "inside",
    "interior": "inside", "insides": "inside", "sides": "sides", "rim": "rim", "lip": "rim", "brim": "rim",
    **{end: end for end in ENDS}, "upper": "top", "lower": "bottom", "rear": "back",
    "above": "above", "below": "below", "box": "box", "sphere": "sphere", "plane": "plane", "segment": "segment",
}  # fmt: skip
"""First word of the notation of a region, by word; those that cannot do without numbers are places only with them."""
NEEDS_NUMBERS: Mapping[str, int] = {"above": 1, "below": 1, "box": 6, "sphere": 4, "plane": 6, "segment": 3}
"""How many numbers the notation of a place needs, by its first word."""
TAKES_A_NUMBER = frozenset([*ENDS, "rim"])
"""First words of the notation of places that may be followed by a length."""
UNKNOWN_PLACES = _of("""
    handle lid foot feet leg hook spout neck belly middle centre center corner edge base underside shoulder hinge arm head tip
    """)
"""Places people speak of that not every part has, or has only one of."""
RECESSES = _of("seam joint mortar grout gap groove crack line vein recess background ground crevice fissure furrow gutter hollow valley")
"""The low places of a relief."""
DEPTHS = _of("deep depth relief emboss engrave raised carve thick recess")
"""Beside a length they say that it is the depth of the relief."""
MILLIMETRES: Mapping[str, float] = {
    "mm": 1.0, "millimetre": 1.0, "millimeter": 1.0, "cm": 10.0, "centimetre": 10.0, "centimeter": 10.0, "inch": 25.4,
}  # fmt: skip
"""A unit of length in mm, by word."""
BEYOND: Mapping[str, str] = {
    **dict.fromkeys(_of("glossy gloss matte matt shiny silky satin transparent translucent clear glow glowing sparkling glitter"),
                    "gloss and glow come from the filament, not from a style"),
    **dict.fromkeys(_of("diagonal horizontal vertical rotate rotated angle degree tilt slanted spiral radial"),
                    "the direction of a pattern follows the part"),
    **dict.fromkeys(_of("gradient fade ombre rainbow multicolour multicolor"),
                    "colours do not run into each other: give each place its own, such as `top: blue brick; bottom: red brick`"),
    **dict.fromkeys(_of("perforate perforated hole cutout pierced"), "a style adds relief and makes no holes"),
    **dict.fromkeys(_of("text letter name number initial"), "letters are not drawn from words"),
    **dict.fromkeys(_of("logo picture"), "pictures are not drawn from words: give the file with --image"),
    **dict.fromkeys(_of("raised emboss embossed engrave engraved carve carved inward inwards outward outwards"),
                    "whether a relief rises or is cut in is a setting"),
    **dict.fromkeys(_of("stronger sturdy thickness thicker thinner taller shorter"),
                    "the shape of the part is its model's: a style changes its surface only"),
}  # fmt: skip
"""What a drawn style cannot do, by word, and what it would take."""
