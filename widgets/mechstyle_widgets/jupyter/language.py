"""The language of what the Studio says itself: one table, from English to German."""

from __future__ import annotations


def word(english: str) -> str:
    """A label in the language in force."""
    return english
