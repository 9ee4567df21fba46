"""Where a C++ source can be changed, and how."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import tree_sitter_cpp
from tree_sitter import Language, Node, Parser

# A piece of the text of a mutant: words, or a part of the source from byte to byte.
Piece = str | tuple[int, int]

# What a compiler has to know, or what is no statement of the program.
LEFT_OUT = {
    "static_assert_declaration", "template_argument_list", "sizeof_expression", "decltype", "array_declarator", "ERROR",
    "template_declaration", "class_specifier", "struct_specifier", "enum_specifier", "noexcept", "string_literal", "char_literal",
}  # fmt: skip
COMPARISONS = {"<", ">", "<=", ">=", "==", "!="}
SHORTER = {"<": "+ 1 ==", "<=": "==", ">": "== 1 +", ">=": "=="}
_PAIRS = (("fmax", "fmin"), ("max", "min"), ("sin", "cos"), ("floor", "ceil"))
OTHER_CALL = {name: other for pair in _PAIRS for name, other in (pair, pair[::-1])}


@dataclass(frozen=True)
class Mutant:
    """One change. name: stays while its statement does; says: what becomes what; pieces: the text with {k} for its
    number, which is the name read as hexadecimal."""

    name: str
    path: str
    line: int
    kind: str
    says: str
    begin: int
    end: int
    pieces: tuple[Piece, ...]


@dataclass(frozen=True)
class Change:
    node: Node
    kind: str
    says: str
    pieces: tuple[Piece, ...]


@cache
def parser() -> Parser:
    return Parser(Language(tree_sitter_cpp.language()))


def mutants_of(path: str, source: bytes) -> list[Mutant]:
    """All of a source, in the order of its text."""
    found: list[Mutant] = []
    seen: Counter[tuple[str, ...]] = Counter()
    ranges = set()
    for body in bodies(parser().parse(source).root_node):
        for change in changes(body):
            node = change.node
            if (node.start_byte, node.end_byte) in ranges:
                continue
            ranges.add((node.start_byte, node.end_byte))
            what = (path, change.kind, plain(statement_of(node)), plain(node), change.says)
            name = hashlib.sha256("\0".join([*what, str(seen[what])]).encode()).hexdigest()[:8]
            seen[what] += 1
            line = node.start_point.row + 1
            found.append(Mutant(name, path, line, change.kind, change.says, node.start_byte, node.end_byte, change.pieces))
    return found


def plain(node: Node) -> str:
    """The text of a node in one line."""
    return re.sub(r"\s+", " ", re.sub(r"//[^\n]*", "", (node.text or b"").decode())).strip()


def statement_of(node: Node) -> Node:
    """The statement or declaration around a node; the condition of an if, not what it guards."""
    whole = ("declaration", "field_initializer", "condition_clause")
    while node.parent and not (node.type.endswith("statement") or node.type in whole):
        node = node.parent
    return node


def says_constexpr(node: Node) -> bool:
    return any(child.type in ("type_qualifier", "constexpr") and child.text == b"constexpr" for child in node.children)


def bodies(node: Node) -> Iterator[Node]:
    """Bodies and initialisers of the functions that run, not those that a compiler evaluates."""
    if node.type == "function_definition":
        if not says_constexpr(node):
            yield from (child for child in node.children if child.type in ("compound_statement", "field_initializer_list"))
        return
    for child in node.children:
        yield from bodies(child)


def changes(node: Node) -> Iterator[Change]:
    """Of a node and all below it."""
    if node.type in LEFT_OUT or (node.type in ("declaration", "if_statement") and says_constexpr(node)):
        return
    if node.type == "declaration" and any(child.text == b"static" for child in node.children):
        return
    if not node.has_error:
        yield from changes_here(node)
    for child in node.children:
        # A label of a switch is a constant.
        if node.type == "case_statement" and child == node.child_by_field_name("value"):
            continue
        yield from changes(child)


def changes_here(node: Node) -> Iterator[Change]:
    for rule in (of_condition, of_binary, of_assignment, of_unary, of_constant, of_call, of_statement):
        yield from rule(node)


def span(node: Node) -> tuple[int, int]:
    return node.start_byte, node.end_byte


def part(node: Node, field: str) -> Node:
    child = node.child_by_field_name(field)
    assert child is not None, f"{node.type} without {field}"
    return child


def negated(node: Node, kind: str) -> Change:
    return Change(node, kind, f"{plain(node)} -> its contrary", ("(hnav_mutant<{k}>() != static_cast<bool>(", span(node), "))"))


def of_condition(node: Node) -> Iterator[Change]:
    if node.type in ("if_statement", "while_statement"):
        condition = part(node, "condition")
        inner = condition.child_by_field_name("value")
        # Comparisons and what joins them have changes of their own.
        if inner is not None and inner.type not in ("declaration", "binary_expression"):
            yield negated(inner, "condition")
    elif node.type == "conditional_expression" and part(node, "condition").type != "binary_expression":
        yield negated(part(node, "condition"), "condition")


def of_binary(node: Node) -> Iterator[Change]:
    if node.type != "binary_expression":
        return
    left, right, sign = part(node, "left"), part(node, "right"), plain(part(node, "operator"))
    pieces: tuple[Piece, ...]
    text = f"{plain(left)} {sign} {plain(right)}"
    if sign in COMPARISONS:
        # One pass less, never one too many: memory beyond a bound is undefined, and tests need not detect that.
        if sign in SHORTER and node.parent is not None and node.parent.type == "for_statement":
            pieces = ("(", span(node), " && !(hnav_mutant<{k}>() && (", span(left), f") {SHORTER[sign]} (", span(right), ")))")
            yield Change(node, "bound", f"{text} -> one pass less", pieces)
        else:
            yield negated(node, "comparison")
    elif sign in ("&&", "||"):
        other = "||" if sign == "&&" else "&&"
        yield Change(node, "logic", f"{text} -> {other}", chosen(left, right, other, sign))
    elif sign in ("+", "-"):
        other = "-" if sign == "+" else "+"
        pieces = (span(left), f" {sign} hnav_flipped<{{k}}>(", span(right), ")")
        yield Change(node, "sum", f"{text} -> {other}", pieces)
    elif sign in ("*", "/"):
        other = "/" if sign == "*" else "*"
        pieces = (span(left), f" {sign} hnav_inverted<{{k}}>(", span(right), ")")
        yield Change(node, "product", f"{text} -> {other}, twice if a matrix", pieces)


def chosen(left: Node, right: Node, other: str, sign: str) -> tuple[Piece, ...]:
    a, b = span(left), span(right)
    return "(hnav_mutant<{k}>() ? (", a, f") {other} (", b, ") : (", a, f") {sign} (", b, "))"


def of_assignment(node: Node) -> Iterator[Change]:
    if node.type != "assignment_expression":
        return
    left, right, sign = part(node, "left"), part(node, "right"), plain(part(node, "operator"))
    other = {"+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}.get(sign)
    if other:
        helper = "hnav_flipped" if sign[0] in "+-" else "hnav_inverted"
        says = f"{plain(left)} {sign} {plain(right)} -> {other}"
        yield Change(right, "assignment", says, (helper + "<{k}>(", span(right), ")"))


def of_unary(node: Node) -> Iterator[Change]:
    if node.type != "unary_expression":
        return
    argument, sign = part(node, "argument"), plain(part(node, "operator"))
    if sign == "-" and argument.type != "number_literal":
        yield Change(node, "sign", f"{plain(node)} -> {plain(argument)}", ("hnav_flipped<{k}>(", span(node), ")"))
    elif sign == "!":
        yield negated(node, "condition")


def of_constant(node: Node) -> Iterator[Change]:
    if node.type in ("true", "false"):
        says = f"{plain(node)} -> its contrary in {plain(statement_of(node))[:100]}"
        yield Change(node, "constant", says, ("(hnav_mutant<{k}>() != ", span(node), ")"))
    elif node.type == "number_literal":
        text = plain(node)
        if re.fullmatch(r"\d+", text):
            around = node.parent
            factor = around is not None and around.type == "binary_expression" and plain(part(around, "operator")) in "*/"
            # Downwards: it may be an index.
            other = str(2 * int(text) if factor and int(text) else int(text) - 1 if int(text) else 1)
        elif re.fullmatch(r"[\d.]+(e-?\d+)?", text):
            other = "1.0" if float(text) == 0 else repr(2 * float(text))
        else:
            return
        says = f"{text} -> {other} in {plain(statement_of(node))[:100]}"
        yield Change(node, "constant", says, (f"(hnav_mutant<{{k}}>() ? {other} : {text})",))


def of_call(node: Node) -> Iterator[Change]:
    if node.type != "call_expression":
        return
    function = part(node, "function")
    name = re.fullmatch(r"std::(\w+)", plain(function))
    if name and name[1] in OTHER_CALL:
        other, arguments = f"std::{OTHER_CALL[name[1]]}", part(node, "arguments")
        pieces = ("(hnav_mutant<{k}>() ? " + other, span(arguments), " : ", span(function), span(arguments), ")")
        yield Change(node, "call", f"{plain(node)} -> {other}", pieces)


def of_statement(node: Node) -> Iterator[Change]:
    """A call or an assignment that is left out."""
    left_out = ("call_expression", "assignment_expression", "update_expression")
    if node.type == "expression_statement" and node.children and node.children[0].type in left_out:
        yield Change(node, "statement", f"{plain(node)} -> left out", ("{ if (!hnav_mutant<{k}>()) ", span(node), " }"))
