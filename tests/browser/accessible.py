"""Whether everybody can read a page: rules of WCAG by axe-core, and its width."""

from axe_playwright_python.sync_playwright import Axe

RULES = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]}


def violations(page):
    """What axe-core finds, by rule, with the elements."""
    found = Axe().run(page, options=RULES).response["violations"]
    return {
        rule["id"]: [node["html"][:200] for node in rule["nodes"]] for rule in found
    }


def cut_off(page):
    """Elements that hold more than they show, once all that is folded is open.

    But for headings of tables that screen readers alone are told.
    """
    page.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)")
    return page.evaluate(
        """[...document.body.querySelectorAll('*')]
        .filter(e => getComputedStyle(e).display !== 'inline' && e.clientWidth > 1)
        .filter(e => e.scrollWidth > e.clientWidth + 1)
        .filter(e => !e.closest('thead')
            || getComputedStyle(e.closest('thead')).position !== 'absolute')
        .map(e => e.outerHTML.slice(0, 200))"""
    )


def overflow(page):
    """Pixels by which the page is wider than its window."""
    return page.evaluate(
        "document.documentElement.scrollWidth - document.documentElement.clientWidth"
    )
