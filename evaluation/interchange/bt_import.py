"""Reading of BehaviorTree.CPP's XML, versions 3 and 4, as a task."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from handcart.files.errors import FileError, Finding
from handcart.files.suggest import suggest

from .lost import Imported, LostConstruct
from .task_draft import TaskDraft
from .tree_flow import TreeFlow
from .tree_node import BehaviourNode
from .xml_tree import XmlElement, read_xml_tree

VERBOSE_TAGS = ("Action", "Condition", "Control", "Decorator")
"""Tags whose attribute ID names the node."""
SCRIPT_TAGS = ("Script", "ScriptCondition", "SetBlackboard", "UnsetBlackboard", "Precondition")
REMAP_TAG = "remap"
"""Child of a SubTree that names an entry of the blackboard inside and outside, in files of version 3."""
QUIET_ATTRIBUTES = ("_description", "_fullpath", "_uid")


def import_tree(path: Path | str) -> Imported:
    """Convert a behaviour tree in a file of BehaviorTree.CPP to a task.

    Raises:
        FileError: the file is not a behaviour tree.
    """
    root = read_xml_tree(path)
    if root.tag != "root":
        wrong = f"the root element is {root.tag!r}; allowed: root, as BehaviorTree.CPP has it"
        raise FileError([Finding(str(path), root.line, root.column, wrong)])
    lost: dict[LostConstruct, None] = {}
    _check_names(path, root)
    trees = {}
    for element in root.children:
        if element.tag == "BehaviorTree":
            trees[_name(element)] = _tree(element, lost)
        elif element.tag != "TreeNodesModel":
            meaning = "a file that is included is not read" if element.tag == "include" else "it is dropped"
            lost[LostConstruct(element.line, element.column, f"<{element.tag}>", meaning)] = None
    main = _main(path, root, trees)
    if len(trees) > 1 and "main_tree_to_execute" not in root.attributes:
        meaning = f"main_tree_to_execute is missing; it begins with {main!r}"
        lost[LostConstruct(root.line, root.column, "<root>", meaning)] = None
    draft = TaskDraft(main)
    flow = TreeFlow(draft, trees)
    start = flow.translate(main)
    return Imported(draft.data(start, backwards=True), tuple(sorted({**lost, **flow.lost})))


def _name(tree: XmlElement) -> str:
    return tree.attributes.get("ID", "MainTree")


def _check_names(path: Path | str, root: XmlElement) -> None:
    """Raise `FileError` for each tree that has the name of another one."""
    first, findings = dict[str, XmlElement](), list[Finding]()
    for tree in root.children:
        if tree.tag == "BehaviorTree" and first.setdefault(_name(tree), tree) is not tree:
            wrong = f"a second tree {_name(tree)!r}, the first is in line {first[_name(tree)].line}"
            findings.append(Finding(str(path), tree.line, tree.column, f"{wrong}; allowed: one of each ID"))
    if findings:
        raise FileError(findings)


def _main(path: Path | str, root: XmlElement, trees: dict[str, BehaviourNode]) -> str:
    """Return the name of the main tree."""
    if not trees:
        wrong = "there is no BehaviorTree; needed: at least one"
        raise FileError([Finding(str(path), root.line, root.column, wrong)])
    main = root.attributes.get("main_tree_to_execute", next(iter(trees)))
    if main not in trees:
        wrong = f"unknown tree {main!r}{suggest(main, trees)}"
        raise FileError([Finding(str(path), root.line, root.column, wrong)])
    return main


def _tree(element: XmlElement, lost: dict[LostConstruct, None]) -> BehaviourNode:
    children = tuple(_node(child, lost) for child in element.children)
    if len(children) == 1:
        return children[0]
    return BehaviourNode("Sequence", "", {}, children, element.line, element.column)


def _node(element: XmlElement, lost: dict[LostConstruct, None]) -> BehaviourNode:
    ports = dict(element.attributes)
    name = ports.pop("name", "")
    kind = ports.pop("ID", element.tag) if element.tag in VERBOSE_TAGS else element.tag
    if "BTCPP_format" in ports:
        ports.pop("BTCPP_format")
    for loss in _losses(element, kind, ports):
        lost[loss] = None
    plain = {key: text for key, text in ports.items() if not key.startswith("_")} | _remapped(element)
    children = tuple(_node(child, lost) for child in element.children if child.tag != REMAP_TAG)
    if kind.startswith("Switch") and kind[6:].isdigit():
        return BehaviourNode("Fallback", name, {}, children, element.line, element.column)
    return BehaviourNode(kind, name, plain, children, element.line, element.column, f"<{kind}>")


def _remapped(element: XmlElement) -> dict[str, str]:
    """Return the ports that a subtree of version 3 is given by elements `remap`."""
    remaps = [child.attributes for child in element.children if child.tag == REMAP_TAG]
    return {
        remap["internal"]: f"{{{remap['external']}}}"
        for remap in remaps
        if {"internal", "external"} <= remap.keys()
    }


def _losses(element: XmlElement, kind: str, ports: dict[str, str]) -> Iterator[LostConstruct]:
    here = element.line, element.column
    for key in ports:
        if key.startswith("_") and key not in QUIET_ATTRIBUTES:
            yield LostConstruct(*here, f"{key} of <{kind}>", "the attribute is dropped")
    if kind in SCRIPT_TAGS:
        yield LostConstruct(
            *here, f"<{kind}>", "scripts on the blackboard are not carried out; it is an action"
        )
    if kind.startswith("Switch") and kind[6:].isdigit():
        yield LostConstruct(*here, f"<{kind}>", "its cases are tried in order, whatever its variable is")
    if kind.startswith("Loop") and element.children:
        yield LostConstruct(*here, f"<{kind}>", "its child is done once, not for each entry of a queue")
