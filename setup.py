"""What is installed: folders of the checkout, as packages below `restir_gi`."""

from tempfile import TemporaryDirectory

from setuptools import find_packages, setup

NAMESPACE = "restir_gi"
FOLDERS = {
    "reference": "reference",
    "extensions": "extensions",
    "hashgrid": "hashgrid",
    "gradient_domain": "gradient_domain",
    "figures": "docs/figures",
}
PACKAGES = {f"{NAMESPACE}.{name}": folder for name, folder in FOLDERS.items()}
INNER = [
    f"{p}.{name}" for p, folder in PACKAGES.items() for name in find_packages(folder)
]

# A build folder that stays would put modules that are gone into the next wheel.
with TemporaryDirectory() as build:
    setup(
        packages=[NAMESPACE, *PACKAGES, *INNER],
        package_dir=PACKAGES,
        package_data={NAMESPACE: ["py.typed"], "": ["*.json", "templates/*"]},
        include_package_data=False,  # these patterns alone
        options={"build": {"build_base": build}},
    )
