"""Lists the crates that a program is made of, as a CycloneDX SBOM and as one file of their licences.

    python3 .ci/release/parts.py --target TARGET --sbom FILE.json --licenses FILE.txt

In: `cargo tree` for one target and `cargo metadata`, both of the lock file; the packages' own licence files. Out: the same
bytes for the same lock file. Crates that are only built with (build and test dependencies) are left out.
"""

import argparse
import json
import pathlib
import subprocess


def shipped(target):
    """Returns the packages that are linked into the program, sorted by name."""
    # The tree knows which dependencies a target and the features leave out; the metadata know the rest.
    tree = ["cargo", "tree", "--locked", "--target", target, "--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"]
    lines = subprocess.check_output(tree, text=True).splitlines()
    linked = {tuple(line.split()[:2]) for line in lines if line}
    metadata = json.loads(subprocess.check_output(["cargo", "metadata", "--locked", "--format-version", "1"]))
    parts = [p for p in metadata["packages"] if (p["name"], "v" + p["version"]) in linked]
    assert len(parts) == len(linked), "packages of one name and version"
    return sorted(parts, key=lambda p: (p["name"], p["version"]))


def sbom(parts, checksums):
    """Returns the list in CycloneDX 1.5."""
    def component(part):
        entry = {
            "type": "application" if part["name"] == "fbptr" else "library",
            "bom-ref": f'pkg:cargo/{part["name"]}@{part["version"]}',
            "name": part["name"],
            "version": part["version"],
            "purl": f'pkg:cargo/{part["name"]}@{part["version"]}',
            "licenses": [{"expression": part["license"].replace("/", " OR ")}],
        }
        checksum = checksums.get((part["name"], part["version"]))
        if checksum:
            entry["hashes"] = [{"alg": "SHA-256", "content": checksum}]
        return entry

    entries = [component(part) for part in parts]
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": next(e for e in entries if e["name"] == "fbptr")},
        "components": [e for e in entries if e["name"] != "fbptr"],
    }


def licenses(parts):
    """Returns the licence files of all foreign crates, each text once, with the crates that it is of."""
    texts = {}
    lines = ["Crates in this program, and their licences.\n"]
    for part in parts:
        if not part["source"]:
            continue
        name = f'{part["name"]} {part["version"]}'
        lines.append(f'{name}: {part["license"]}; {part["repository"] or part["homepage"] or "no address"}\n')
        folder = pathlib.Path(part["manifest_path"]).parent
        for path in sorted(folder.iterdir()):
            if path.is_file() and path.name.upper().startswith(("LICENSE", "LICENCE", "COPYING", "NOTICE", "COPYRIGHT")):
                text = path.read_text(encoding="utf-8", errors="replace").replace("\r\n", "\n").strip()
                texts.setdefault(text, []).append(name)
    for text, names in texts.items():
        lines.append(f'\n{"=" * 80}\n{", ".join(dict.fromkeys(names))}\n\n{text}\n')
    return "".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--target", required=True)
    parser.add_argument("--sbom", required=True)
    parser.add_argument("--licenses", required=True)
    args = parser.parse_args()
    parts = shipped(args.target)
    checksums, package = {}, {}
    for line in pathlib.Path("Cargo.lock").read_text().splitlines():
        if line == "[[package]]":
            package = {}
        elif " = " in line:
            key, value = line.split(" = ", 1)
            package[key] = value.strip('"')
            if key == "checksum":
                checksums[package["name"], package["version"]] = package["checksum"]
    pathlib.Path(args.sbom).write_text(json.dumps(sbom(parts, checksums), indent=1) + "\n")
    pathlib.Path(args.licenses).write_text(licenses(parts))
    print(f"{len(parts)} parts")


main()
