"""What a browser receives of the page: its meaning, its size, when it is sent again."""

from __future__ import annotations

import re
import shutil
import subprocess
import urllib.parse
from pathlib import Path

import pytest

from arael.sketch.server.compact import compact_script, compact_style
from tests import optional

optional.require("starlette")
optional.require("websockets")

from starlette.applications import Starlette  # noqa: E402
from starlette.routing import Mount  # noqa: E402
from starlette.testclient import TestClient  # noqa: E402

from arael.sketch.server.app import PAGE  # noqa: E402
from arael.sketch.server.page_files import PageFiles  # noqa: E402

MOST_BYTES = 300_000
"""Of all files that a browser loads, before and after their compression."""

TESTS = Path(__file__).parents[2] / "page"
IMPORT = re.compile(r"(?:from|import|href=|src=)\s*\(?\s*[\"']([^\"':]+\.(?:js|css))[\"']")


@pytest.fixture
def browser() -> TestClient:
    return TestClient(Starlette(routes=[Mount("/", PageFiles(directory=PAGE, html=True))]))


def loaded(browser: TestClient) -> dict[str, tuple[int, int]]:
    """Bytes over the wire and after decompression, by address, of all that a page loads."""
    found: dict[str, tuple[int, int]] = {}
    waiting = ["/"]
    while waiting:
        address = waiting.pop()
        if address in found:
            continue
        answer = browser.get(address)
        assert answer.status_code == 200 and answer.headers["content-encoding"] == "gzip"
        found[address] = int(answer.headers["content-length"]), len(answer.content)
        waiting += [urllib.parse.urljoin(address, one) for one in IMPORT.findall(answer.text)]
    return found


def test_what_a_browser_loads_is_small(browser: TestClient) -> None:
    sizes = loaded(browser)
    assert len(sizes) > 80 and "/draw/batches.js" in sizes and "/styles/phone.css" in sizes
    wire, plain = (sum(one) for one in zip(*sizes.values(), strict=True))
    assert wire < 0.5 * MOST_BYTES
    assert plain < MOST_BYTES


def test_a_file_that_the_browser_has_is_not_sent_again(browser: TestClient) -> None:
    first = browser.get("/pick.js")
    again = browser.get("/pick.js", headers={"if-none-match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_a_file_that_was_changed_is_sent_anew(tmp_path: Path) -> None:
    app = Starlette(routes=[Mount("/", PageFiles(directory=tmp_path))])
    (tmp_path / "a.js").write_text("let a = 1; // one")
    browser = TestClient(app)
    first = browser.get("/a.js")
    (tmp_path / "a.js").write_text("let a = 12; // twelve")
    again = browser.get("/a.js", headers={"if-none-match": first.headers["etag"]})
    assert first.text == "let a=1;\n" and again.text == "let a=12;\n"


def test_a_client_without_decompression_gets_plain_text(browser: TestClient) -> None:
    answer = browser.get("/pick.js", headers={"accept-encoding": "identity"})
    assert "content-encoding" not in answer.headers and "class Picker" in answer.text


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("const a = 1; // one\n\n// two\nlet b = a", "const a=1;let b=a"),
        ("/** @type {A} */ (a).b", "(a).b"),
        ("a = 1 /* x\n y */\nb", "a=1\nb"),
        ("x + +y - -z + ++w", "x+ +y- -z+ ++w"),
        ('return /a b\\/[/ "]/g.test(c) / 2', 'return/a b\\/[/ "]/g.test(c)/2'),
        ("a / b / c", "a/b/c"),
        ("f(a) / 2 // half", "f(a)/2"),
        ("s = \"// a  b\" + '/* c */'", "s=\"// a  b\"+'/* c */'"),
        (
            "`a  // b ${ { c : `d  ${ e  +  1 }` } . c }  f` / 2",
            "`a  // b ${{c:`d  ${e+1}`}.c}  f`/2",
        ),
        ("`\\`  \\${ x }  $  `", "`\\`  \\${ x }  $  `"),
        ("a =\nb\n.c ||\nd\n? e\n: f\n&& g", "a=b.c||d?e:f&&g"),
        ("a++\nb\n++c\n-d\n/e/.f", "a++\nb\n++c\n-d\n/e/.f"),
        ("a\n(b)\n[c]", "a\n(b)\n[c]"),
        ("if (a) {\n  b()\n}\nc", "if(a){b()}c"),
        ("if (a) b = function () {}\nc", "if(a)b=function(){}\nc"),
        ("if (a) b = {}\nelse {\n}\nc", "if(a)b={}\nelse{}c"),
        ("a = b ? function () {} : {}\nc", "a=b?function(){}:{}\nc"),
        (
            "function a({ b } = {}) {\n}\nclass C extends f(a) {\n}\nc",
            "function a({b}={}){}class C extends f(a){}c",
        ),
        (
            "export async function a() {}\nexport default class {}\nc",
            "export async function a(){}export default class{}c",
        ),
        (
            "class A {\n  a() {}\n  get b() {}\n  c = () => {}\n  d = function () {}\n}",
            "class A{a(){}get b(){}c=()=>{}\nd=function(){}}",
        ),
        (
            "class A {\n  [b({})]() {}\n  static {\n  }\n  c() {}\n}\nd",
            "class A{[b({})](){}static{}\nc(){}}d",
        ),
        ("a\nfunction f() {}\nconst g = class {}\nb", "a\nfunction f(){}\nconst g=class{}\nb"),
        ("try {\n}\ncatch (a) {\n}\nfinally {\n}\nb", "try{}catch(a){}finally{}b"),
        ("f(a, { b, }, [c, [,], [, d,], e,],);", "f(a,{b},[c,[,],[,d],e]);"),
        ("`${function () {}}`\nfor (;;) {}\nb", "`${function(){}}`\nfor(;;){}b"),
        ("f({ a: true }) || (false ? true : false)", "f({a:!0})||(!1?!0:!1)"),
        ("return true in a; case false: b = true\n/ 2", "return!0 in a;case!1:b=!0\n/2"),
        (
            "a = { true: 1, false : 2 }; a.true; true.b; true()",
            "a={true:1,false:2};a.true;true.b;true()",
        ),
        ("a = { undefined }; b = { c, undefined }", "a={undefined};b={c,undefined}"),
        ("return undefined; a === undefined\nb", "return void 0;a===void 0\nb"),
        ("a < true; b ? c : true\nd", "a< !0;b?c:!0\nd"),
        ("switch (a) {\n}\n(b)", "switch(a){}(b)"),
        ("x = 1 .toFixed()", "x=1 .toFixed()"),
        ("class A { #b = 1; static async *c() {} }", "class A{#b=1;static async*c(){}}"),
        ("x in y; a instanceof B", "x in y;a instanceof B"),
        ("let é = ü in ö", "let é=ü in ö"),
        ("if (a) { b(); c(); }\nd", "if(a){b();c()}d"),
        ("(a) => (b, c) => () => a", "a=>(b,c)=>()=>a"),
        ("f(async (a) => ({ a }), (a = 1) => a)", "f(async a=>({a}),(a=1)=>a)"),
        ("return 0.5 - 10.5 + a[0].b ? 0.25 : 0", "return.5-10.5+a[0].b?.25:0"),
        ("{ for (;;); }", "{for(;;);}"),
        ("{ while (a(b)); }", "{while(a(b));}"),
        ("{ if (a) b(); else; }", "{if(a)b();else;}"),
        ("`${() => { a(); }}`", "`${()=>{a()}}`"),
        ("const a = 1;\nconst b = 2;\nlet c;\nlet d;", "const a=1,b=2;let c,d;"),
        ("const [a] = x; const { b } = y; // c\nconst c = {};", "const[a]=x,{b}=y,c={};"),
        ("export const a = 1;\nconst b = 2;\nconst c = 3;", "export const a=1;const b=2,c=3;"),
        ("const a = 1; f(); const b = 2;", "const a=1;f();const b=2;"),
        ("for (let i = 0; i < 2; i++) let;", "for(let i=0;i<2;i++)let;"),
        ("{ const a = 1; } const b = 2;", "{const a=1}const b=2;"),
        (
            "const f = () => { let a = 1; let b; a(); }; const g = [0, { c }]; let h;",
            "const f=()=>{let a=1,b;a()},g=[0,{c}];let h;",
        ),
        (
            "const a = `;${() => { let b; let c; }}`; const d = a;",
            "const a=`;${()=>{let b,c}}`,d=a;",
        ),
    ],
)
def test_a_script_keeps_its_meaning(source: str, expected: str) -> None:
    assert compact_script(source) == expected + "\n"


def test_a_style_sheet_keeps_its_meaning() -> None:
    source = '/* a */\n.b  > :is(c, d) {\n  width: calc(1px + 2px);\n  content: "/* e */  ;";\n}\n'
    expected = '.b > :is(c,d){width:calc(1px + 2px);content:"/* e */  ;"}\n'
    assert compact_style(source) == expected


def test_compacting_twice_changes_nothing_more() -> None:
    for path in PAGE.rglob("*.js"):
        if "node_modules" not in path.parts:
            once = compact_script(path.read_text(encoding="utf-8"))
            assert compact_script(once) == once, path


def test_the_page_passes_its_tests_as_it_is_sent(tmp_path: Path) -> None:
    node = optional.program("node")
    page, tests = tmp_path / PAGE.relative_to(PAGE.parents[2]), tmp_path / "tests" / "page"
    for path in PAGE.rglob("*"):
        if path.suffix in (".js", ".css", ".html", ".json") and "node_modules" not in path.parts:
            copy = page / path.relative_to(PAGE)
            copy.parent.mkdir(parents=True, exist_ok=True)
            text = path.read_text(encoding="utf-8")
            copy.write_text(compact_script(text) if path.suffix == ".js" else text, "utf-8")
    shutil.copytree(TESTS, tests)
    files = sorted(map(str, tests.glob("*.test.js")))
    done = subprocess.run([node, "--test", *files], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]
