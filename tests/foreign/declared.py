"""What the renderers of this folder would declare of themselves."""

SCHEMA = "restir-declaration 1"

ORDERS = {
    "own first": "own-first",
    "past last": "past-last-in-place",
    "neighbors reversed": "neighbors-turned-in-place",
    "own first, neighbors reversed": "own-first-turned-in-place",
    "reversed": "reversed",
}
"""Orders whose numbers belong to a place."""

BY_RESERVOIR = {
    "own first": "own-first",
    "past last": "past-last",
    "neighbors reversed": "neighbors-turned",
    "own first, neighbors reversed": "own-first-turned",
    "reversed": "neighbors-own-past-turned",
}
"""The same orders where they belong to a reservoir."""

CAPS = {
    "arrival": "on arrival, neighbors too",
    "past": "past on arrival",
    "both": "both, neighbors too",
    "never": "never",
}

TARGETS = {
    "outgoing": {"kind": "outgoing"},
    "no albedo": {"kind": "scattered", "albedo": False, "pis": 0},
    "no pi": {"pis": 0},
    "doubled": {"scale": 2},
    "root": {"root": True},
}

LUMINANCES = {"601": "rec601", "mean": "mean", "sum": "sum", "largest": "largest"}

MIS = {
    "balance": {"mis": "balance"},
    "balance first": {"mis": "balance-in-weights"},
    "uneven": {"mis": "balance", "mis_jacobian": False},
    "pairwise": {"mis": "pairwise"},
    "defensive": {"mis": "defensive"},
    "share": {"mis": "pairwise-of-k"},
    "chained": {"mis": "chained-balance"},
}

STORAGES = {
    "half radiance": {"storage": "half-radiance"},
    "half W": {"storage": "half-weight"},
    "RGBE": {"storage": "rgbe-float-weight"},
    "octahedral": {"storage": "octahedral"},
    "RTXDI": {"storage": "rtxdi", "M": {"whole": True, "most": 255}},
    "32 bytes": {"storage": "rgbe", "M": {"whole": True, "most": 255}},
}


def choices_of(options):
    """The table of choices of a renderer with these options."""
    found, target = {}, {}
    if options.order != "contract":
        names = ORDERS if options.draws == "position" else BY_RESERVOIR
        found["order"] = names[options.order]
    if options.u != "u":
        found["u"] = "1 - u"
    if options.cap != "closed":
        found["cap"] = CAPS[options.cap]
    target |= TARGETS.get(options.target, {})
    if options.luminance != "709":
        target["luminance"] = LUMINANCES[options.luminance]
    if options.floor:
        target["least"] = options.floor
    if not options.back_test:
        target["back"] = "jacobian"
        found["shading_asks_back"] = False
    if options.null_weight:
        found["W_of_nulls"] = "1/pdf"
    if options.limit:
        limits = [1 / options.limit, options.limit]
        found["jacobian"] = {"refused_both_ways": limits}
    if options.bytes:
        found["M"] = {"whole": True, "most": 255}
    found |= MIS.get(options.mis, {}) | STORAGES.get(options.storage, {})
    return found | ({"target": target} if target else {})


def declaration_of(renderer, accept=(), **choices):
    """The declaration of a renderer, with further choices."""
    table = choices_of(renderer.options) | choices
    return {"schema": SCHEMA, "accept": list(accept), "choices": table}
