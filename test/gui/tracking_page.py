"""The page of a tracking window, as a user sees it."""

PICTURE = "document.querySelector('.ct-stage canvas')?.frameView?.description"
"""The packet on the canvas, in the words of the page's scripts."""


class TrackingPage:
    """A page that shows a frame that was tracked."""

    def __init__(self, page):
        self.page = page
        self.wait_for(f"{PICTURE} && {PICTURE}.status !== 'WARMING UP'")

    def at(self, name):
        return self.page.locator(f"[data-test={name}]")

    def wait_for(self, expression):
        self.page.wait_for_function(expression)

    def picture(self):
        """Return the packet on the canvas, without its bytes."""
        return self.page.evaluate(
            f"(({{parts, ...rest}}) => ({{...rest, cloud: parts.cloud?.rows}}))({PICTURE})"
        )

    def drag(self, begin, end):
        """Draw a stroke from one place of the page to another."""
        mouse = self.page.mouse
        mouse.move(*begin)
        mouse.down()
        mouse.move(*end, steps=4)
        mouse.up()
