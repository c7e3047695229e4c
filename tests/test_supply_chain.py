"""What runs asks no network but in one place, and an audit of the locked packages is not taken for done where nothing could be asked."""

import ast
import importlib.util
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FETCHES = Path("workflow/study/measured/originals.py")
"""The one module that fetches: originals of measured sets, each known by its checksum."""
CLIENTS = frozenset(
    "urllib.request http socket socketserver ssl ftplib smtplib poplib imaplib telnetlib nntplib xmlrpc asyncio webbrowser requests httpx aiohttp "
    "urllib3 boto3 botocore paramiko websocket websockets grpc pycurl fsspec smart_open pooch".split()
)
"""Modules that can open a connection, or have another program open one."""
REMOTE_GIT = frozenset({"clone", "fetch", "pull", "push", "ls-remote", "submodule"})
"""What git asks a network for; its other commands read the checkout."""
PROGRAMS = frozenset({"curl", "wget", "ssh", "scp", "rsync", "ftp", "nc"})
READERS = frozenset(
    {"read_csv", "read_table", "read_json", "read_parquet", "read_excel", "read_html", "read_xml"}
)
"""Functions of pandas that fetch if they are given an address."""


def modules() -> list[Path]:
    """Return every module of the package and of the workflow, from the root of the checkout."""
    found = [path for folder in ("scalar", "workflow") for path in sorted((ROOT / folder).rglob("*.py"))]
    return [path.relative_to(ROOT) for path in found]


def imported(tree: ast.AST) -> Iterator[str]:
    """Yield the name of each module that is imported anywhere in a module, by a statement or by its name as text."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called in ("import_module", "__import__"):
                yield str(node.args[0].value)


def clients(tree: ast.AST) -> set[str]:
    """Return the network clients that a module imports, starts as a program, or gives an address to."""
    found = {
        name
        for name in imported(tree)
        if any(name == client or name.startswith(client + ".") for client in CLIENTS)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.List) and node.elts:
            program, *rest = (each.value if isinstance(each, ast.Constant) else None for each in node.elts)
            if program in PROGRAMS or (program == "git" and REMOTE_GIT & set(rest)):
                found.add(f"the program {program}")
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in READERS:
            found |= {
                f"{node.func.attr} of an address"
                for each in node.args[:1]
                if isinstance(each, ast.Constant) and "://" in str(each.value)
            }
    return found


def test_only_the_fetch_rule_has_a_network_client() -> None:
    """No module of the package or of the workflow can ask a network, but the one that fetches the originals of measured sets."""
    found = {path: clients(ast.parse((ROOT / path).read_text(encoding="utf-8"))) for path in modules()}
    assert len(found) > 300
    assert {path: names for path, names in found.items() if names} == {
        FETCHES: {"urllib.request", "urllib.request.Request", "urllib.request.urlopen"}
    }


@pytest.mark.parametrize(
    "text",
    [
        "import socket",
        "def f():\n    from urllib.request import urlopen",
        "from urllib import request",
        "import http.client as h",
        "import importlib\nimportlib.import_module('requests')",
        "import subprocess\nsubprocess.run(['curl', address])",
        "import subprocess\nsubprocess.run(['git', '-C', folder, 'fetch'])",
        "import pandas as pd\npd.read_csv('https://example/table.csv')",
    ],
)
def test_a_client_is_seen(text: str) -> None:
    """Each way to ask a network is recognised."""
    assert clients(ast.parse(text))


def test_reading_a_name_from_an_address_is_no_client() -> None:
    """Errors and parsers of addresses open no connection."""
    assert not clients(ast.parse("from urllib.error import HTTPError\nfrom urllib.parse import quote"))


@pytest.fixture
def audit():
    """Return the module behind `make audit`."""
    spec = importlib.util.spec_from_file_location("audit", ROOT / ".ci/audit.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def table(*packages: dict[str, object]) -> str:
    """Return what pip-audit prints for some packages."""
    return json.dumps({"dependencies": packages, "fixes": []})


SAFE = {"name": "numpy", "version": "2.4.0", "vulns": []}
UNKNOWN = {"name": "lmfit", "skip_reason": "Dependency not found"}
UNSAFE = {"name": "pandas", "version": "1.0", "vulns": [{"id": "CVE-1"}]}


@pytest.mark.parametrize(
    ("answer", "status", "said"),
    [
        (table(SAFE, SAFE), 0, "no known vulnerability in 2 locked packages"),
        (table(SAFE, UNKNOWN), 0, "1 could not be looked up"),
        (table(UNKNOWN, UNKNOWN), 0, "skipped: the database of vulnerabilities answered for none of 2"),
        (table(SAFE, UNSAFE, UNKNOWN), 1, "pandas 1.0 has CVE-1"),
        ("", 1, "no table"),
        ("[]", 1, "no table"),
    ],
    ids=["safe", "partly asked", "nothing asked", "vulnerable", "silent", "another table"],
)
def test_what_an_audit_says(audit, answer: str, status: int, said: str) -> None:
    """A known vulnerability fails; where nothing was asked, that is said, and not that nothing was found."""
    found = audit.judged(answer)
    assert found[0] == status
    assert said in found[1]


def test_without_the_tool_the_audit_says_so(audit, monkeypatch, tmp_path) -> None:
    """Without pip-audit nothing is run, and the sentence names it."""
    monkeypatch.setenv("PATH", str(tmp_path))
    assert audit.audit() == (
        0,
        "audit skipped: there is no pip-audit; install it, outside of .venv, and call this again",
    )
