"""Make `mechstyle/styling/english.tsv`: common English words, and what those look like that WordNet knows as animals, plants or things.

Needs WordNet 3.0 and SCOWL; on Debian the packages `wordnet-base` and `scowl`. Prints the table:

    .venv/bin/python benchmarks/english.py /usr/share/wordnet /usr/share/dict/scowl > mechstyle/styling/english.tsv
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path

from mechstyle.styling import vocabulary

COMMON, RARER = (10, 20, 35, 40), (50, 55, 60, 70)
"""Sizes of SCOWL: of words that everybody knows, and of names of animals, plants and things that more people know than use."""
CLASSES = """
thing bird 1 feathers fish_scales shingles
thing cetacean 1 leather waves fish_scales
thing shark 1 leather grip fish_scales
thing fish 1 fish_scales waves bubbles
thing turtle 2 giraffe voronoi honeycomb
thing reptile 1 dragon_scales fish_scales leather
thing amphibian 3 leather bubbles dots
thing pachyderm 1 leather cracked_earth bark
thing mammal 1 fur fuzzy leather
thing insect 1 panels honeycomb fuzzy
thing arachnid 1 fur fuzzy voronoi
thing mollusk 1 spiral fluted waves
thing crustacean 1 panels dragon_scales bubbles
thing flower 1 floral green mandala
thing tree 1 wood bark green
thing fungus 1 fluted dots bubbles
thing fern 1 green feathers moss
thing grass 1 moss fur basket_weave
thing edible_fruit 1 dots bubbles fuzzy
thing vegetable 1 green fluted bubbles
thing plant 2 green floral moss
thing gem 2 crystal glass low_poly
thing precious_stone 1 crystal glass low_poly
thing mineral 1 crystal stone marble
thing rock 2 stone concrete marble
thing metallic_element 1 hammered brushed_metal panels
thing alloy 1 hammered brushed_metal panels
thing rug 1 fuzzy knit tartan
thing fabric 1 twill knit pleats
thing wood 1 wood bark bamboo
thing paper 1 paper pleats low_poly
thing fur 1 fur fuzzy leather
thing leather 1 leather quilting dragon_scales
thing body_of_water 1 waves ice bubbles
thing geological_formation 1 stone topographic cracked_earth
hint ice 1 ice crystal glass
hint footwear 1 leather knit grip
hint clothing 1 twill knit pleats
hint net 2 voronoi grid knit
hint tower 1 stone brick concrete
hint room 1 tiles wood brick
hint building 1 brick stone concrete
hint structure 1 stone concrete panels
hint furniture 1 wood quilting basket_weave
hint aircraft 1 panels brushed_metal carbon_fibre
hint vessel 2 wood panels waves
hint vehicle 1 panels diamond_plate carbon_fibre
hint weapon 1 damascus hammered knurling
hint musical_instrument 1 wood hammered fluted
hint toy 1 studs dots stripes
hint jewelry 1 crystal hammered celtic_knot
hint container 1 basket_weave wood hammered
hint machine 1 panels knurling circuit
hint electronic_equipment 1 circuit panels brushed_metal
hint tool 1 knurling hammered wood
hint device 1 panels knurling circuit
hint artifact 1 panels brushed_metal wood
hint candy 1 stripes bubbles spiral
hint beverage 1 bubbles waves glass
hint baked_goods 1 cork fuzzy tiles
hint food 2 bubbles dots fuzzy
hint food 1 bubbles dots fuzzy
hint person 1 knit leather chainmail
hint body_part 1 leather fuzzy realistic
hint celestial_body 1 hammered crystal dots
hint weather 1 waves ice fuzzy
hint game 1 tiles studs dots
hint sport 1 grip dots fluted
hint animal 1 fur dragon_scales leather
hint substance 1 stone crystal cork
hint social_event 1 dots floral stripes
hint spiritual_being 1 feathers celtic_knot lava
hint imaginary_being 1 dragon_scales bark fur
hint plant_part 1 green bark wood
hint natural_object 1 stone bark leather
hint vegetation 1 green moss floral
hint natural_phenomenon 1 waves lava ice
hint time_period 1 waves ice green
hint clock_time 1 waves ice green
hint geographical_area 1 topographic green stone
hint location 1 topographic stone green
hint way 6 stone brick tiles
hint music 1 waves stripes art_deco
hint art 1 floral mandala marble
hint feeling 1 waves floral spikes
hint religion 1 stone mandala girih
hint shape 2 waves dots grid
hint pattern 1 grid stripes mandala
"""
"""Kind of row, class as a lemma and the number of its sense, and the styles that come near, nearest first."""


def synsets(folder: Path) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """Hypernyms of each noun synset, and synsets of each noun in the order of their use."""
    above, senses = {}, {}
    for line in (folder / "data.noun").read_text("utf-8").splitlines():
        if not line.startswith("  "):
            fields = line.split(" | ")[0].split()
            start = 4 + 2 * int(fields[3], 16)
            pointers = [fields[start + 1 + 4 * k : start + 5 + 4 * k] for k in range(int(fields[start]))]
            above[fields[0]] = [offset for sign, offset, part, _ in pointers if sign in {"@", "@i"} and part == "n"]
    for line in (folder / "index.noun").read_text("utf-8").splitlines():
        if not line.startswith("  "):
            fields = line.split()
            senses[fields[0]] = [offset for offset in fields[-int(fields[2]) :] if offset in above]
    return above, senses


def ancestors(offset: str, above: dict[str, list[str]]) -> set[str]:
    """A synset and all that it is a kind of."""
    seen, rest = set(), [offset]
    while rest:
        seen.add(offset := rest.pop())
        rest += [other for other in above[offset] if other not in seen]
    return seen


def spelt(folder: Path, sizes: tuple[int, ...]) -> set[str]:
    """Words of SCOWL of some sizes, in small letters, without those that have marks."""
    names = [f"{kind}-words.{size}" for kind in ("english", "american", "british") for size in sizes]
    words = {word for name in names for word in (folder / name).read_text("latin-1").split()}
    return {word for word in words if word.isascii() and word.isalpha() and word.islower() and len(word) > 2}


ENDINGS = (("s", ""), ("es", ""), ("ed", ""), ("ed", "e"), ("ing", ""), ("ing", "e"), ("ies", "y"))
"""Endings that `styling/words` takes off by itself, and what it puts in their place."""


def base(word: str, words: set[str]) -> bool:
    """Whether a word is no plural or other inflection of another one of some."""
    stems = [word[: -len(ending)] + end for ending, end in ENDINGS if word.endswith(ending) and len(word) - len(ending) > 2]
    stems += [stem[:-1] for stem in stems if len(stem) > 3 and stem[-1] == stem[-2]]
    return not any(stem in words and stem != word and base(stem, words) for stem in stems)


def eaten(meanings: list[str], above: dict[str, list[str]], senses: dict[str, list[str]]) -> list[str]:
    """The synsets of a word with a fruit or vegetable before the tree or plant it grows on."""
    plant, *foods = senses["plant"][1], senses["edible_fruit"][0], senses["vegetable"][0]
    food = next((offset for offset in meanings[:3] if not ancestors(offset, above).isdisjoint(foods)), None)
    return [food, *meanings] if food and plant in ancestors(meanings[0], above) else meanings


def misleading(senses: dict[str, list[str]], common: set[str]) -> list[str]:
    """Names of two common words of which the first alone would give the style: a barn owl is a bird, and no barn."""
    styles = vocabulary.styles()
    pairs = [(word, *word.split("_")) for word in sorted(senses) if word.count("_") == 1 and word not in styles]
    return [name for name, first, head in pairs if {first, head} <= common and head in senses and first in styles and head not in styles]


def main() -> None:
    """Print the table."""
    wordnet, scowl = map(Path, sys.argv[1:])
    above, senses = synsets(wordnet)
    lines = map(str.split, CLASSES.strip().splitlines())
    classes = [(kind, senses[lemma][int(sense) - 1], " ".join(near)) for kind, lemma, sense, *near in lines]

    def kind_of(offset: str) -> tuple[str, str] | None:
        line = ancestors(offset, above)
        return next(((kind, near) for kind, top, near in classes if top in line), None)

    common = spelt(scowl, COMMON)
    rows = defaultdict(list)
    for word in sorted(common | spelt(scowl, RARER)):
        found = ("english", "")
        for order, offset in enumerate(eaten(senses.get(word, []), above, senses)[:2]):
            first = kind_of(offset)
            if first:  # what a common word rarely means is only a hint
                found = first if order == 0 or word not in common else ("hint", first[1])
                break
        if (word in common or found[0] == "thing") and base(word, common):
            rows[found].append(word)
    for phrase in misleading(senses, common):
        first, head = kind_of(senses[phrase][0]), kind_of(senses[phrase.partition("_")[2]][0])
        if first == head and first and first[0] == "thing":  # a water dragon is a plant in books alone
            rows[first].append(phrase)
    print("kind\tvalue\tEnglish")
    for (kind, value), words in sorted(rows.items(), key=lambda row: (row[0][0], row[0][1])):
        print(kind, value, " ".join(words), sep="\t")


if __name__ == "__main__":
    main()
