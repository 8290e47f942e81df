import asyncio

import pytest

from cable_tracker.gui.web.access import COOKIE, AccessGuard, is_loopback, make_token

TOKEN = "right"


async def application(scope, receive, send):
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
        return
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"page"})


def answers(token, *, kind="http", host="127.0.0.1:8080", query="", **headers):
    """Return what is sent to one request."""
    fields = {"host": host, **headers}
    scope = {
        "type": kind,
        "query_string": query.encode(),
        "headers": [(key.encode(), value.encode()) for key, value in fields.items()],
    }
    sent = []

    async def send(message):
        sent.append(message)

    async def receive():
        return {"type": "websocket.connect"}

    asyncio.run(AccessGuard(application, token)(scope, receive, send))
    return sent


def passes(token, **request):
    first = answers(token, **request)[0]
    return first.get("status") == 200 or first["type"] == "websocket.accept"


@pytest.mark.parametrize("kind", ["http", "websocket"])
class TestOnLoopback:
    @pytest.mark.parametrize(
        "host", ["127.0.0.1:8080", "localhost:1", "[::1]:8080", "localhost", "127.0.0.2:80"]
    )
    def test_this_machines_own_names_pass(self, kind, host):
        assert passes(None, kind=kind, host=host)

    @pytest.mark.parametrize("host", ["evil.example", "evil.example:8080", "", "192.168.1.9:8080"])
    def test_a_foreign_name_that_points_here_is_refused(self, kind, host):
        assert not passes(None, kind=kind, host=host)

    def test_pages_of_other_hosts_are_refused(self, kind):
        assert passes(None, kind=kind, origin="http://127.0.0.1:8080")
        assert not passes(None, kind=kind, origin="http://evil.example")
        assert not passes(None, kind=kind, origin="http://127.0.0.1:9999")
        assert not passes(None, kind=kind, origin="null")


@pytest.mark.parametrize("kind", ["http", "websocket"])
class TestWithToken:
    def test_only_who_knows_it_passes(self, kind):
        assert passes(TOKEN, kind=kind, host="boat:8080", query="token=right")
        assert not passes(TOKEN, kind=kind, host="boat:8080", query="token=wrong")
        assert not passes(TOKEN, kind=kind, host="boat:8080", query="token=r%C3%A9")
        assert not passes(TOKEN, kind=kind, host="boat:8080")

    def test_the_cookie_stands_in_for_the_token(self, kind):
        assert passes(TOKEN, kind=kind, cookie=f"a=b; {COOKIE}8080={TOKEN}")
        assert not passes(TOKEN, kind=kind, cookie=f"{COOKIE}8080=wrong")
        assert not passes(TOKEN, kind=kind, cookie="\x00;=;;")

    def test_pages_of_other_hosts_are_refused_all_the_same(self, kind):
        request = {"kind": kind, "cookie": f"{COOKIE}8080={TOKEN}"}
        assert not passes(TOKEN, origin="http://evil.example", **request)


def test_the_page_brings_the_cookie():
    headers = answers(TOKEN, query="token=right")[0]["headers"]
    assert any(key == b"set-cookie" and TOKEN.encode() in value for key, value in headers)


def test_servers_on_two_ports_of_a_host_have_cookies_of_their_own():
    """As `gui` and `label` on one machine, in one browser."""
    hosts = ("boat:8080", "boat:8081")
    cookies = [
        dict(answers(word, host=host, query=f"token={word}")[0]["headers"])[b"set-cookie"]
        for word, host in zip(("first", "second"), hosts, strict=True)
    ]
    jar = dict(cookie.decode().split(";")[0].split("=") for cookie in cookies)
    both = "; ".join("=".join(item) for item in jar.items())
    assert passes("first", host=hosts[0], cookie=both)
    assert passes("second", host=hosts[1], cookie=both)
    assert not passes("second", host=hosts[0], cookie=both)


def test_a_refused_page_says_what_to_do():
    start, body = answers(TOKEN)
    assert start["status"] == 403
    assert b"token" in body["body"]
    assert b"set-cookie" not in dict(start["headers"])


@pytest.mark.parametrize("host", ["127.0.0.1", "127.1.2.3", "::1", "localhost"])
def test_loopback_is_known(host):
    assert is_loopback(host)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.0.1", "boat", ""])
def test_everything_else_is_reached_by_others(host):
    assert not is_loopback(host)


def test_tokens_differ():
    assert len({make_token() for _ in range(100)}) == 100
