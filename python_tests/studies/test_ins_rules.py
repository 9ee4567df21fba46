"""The rules of the search for the heading: each can be left out of the sources as they are now."""

import pytest

from hnav.cli.words import UsageError
from hnav.places import CHECKOUT
from studies.ins.rules import RULES, Rule, changed


@pytest.mark.parametrize("name", RULES)
def test_a_rule_is_found_where_the_table_says(name):
    rule = RULES[name]
    source = (CHECKOUT / "c_src" / "ins" / rule.file).read_text()
    assert changed(rule, source) != source
    assert rule.repairs and len(RULES) <= 12


def test_a_rule_that_has_moved_is_named():
    with pytest.raises(UsageError, match="found 0 times"):
        changed(Rule("", "start.cpp", {"no such text": ""}), "int main() {}")
