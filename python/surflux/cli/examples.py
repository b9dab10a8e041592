"""What to type, for the help of each command."""

EXAMPLES = {
    "solve": (
        ("scan.ply", "light a scan: writes scan_solved.ply and .png"),
        ("tile.laz --points 2M -o tile_lit.laz", "an even sample of a large file, in the format it came in"),
        (
            "room.toml -o room.ply --image room.exr --image room.png",
            "a scene, all layers and a picture",
        ),
        ("statue.stl -o lit.vtp", "a mesh, whose faces have their light"),
        ("room.toml --error 1%", "finer until the estimated error is at most that"),
        ("tiles/*.laz --tiles --halo 150 -o lit --image map.png", "a survey tile by tile, into a folder, and its map"),
    ),
    "area": (
        ("scan.ply -o areas.ply", "the area of each surfel"),
        ("scan.xyz --viewpoint=0,0,1.7 --json", "a scan without normals, seen from one place"),
    ),
    "check": (
        ("scan.ply", "which patches point inwards"),
        ("scan.ply --bodies -o turned.ply", "turn them round"),
    ),
    "doctor": (
        ("scan.laz", "what is in the file, and what solve would take for granted"),
        ("scan.laz --json", "the same for programs"),
    ),
    "render": (
        ("scan_solved.ply --eye 1,-3,2 --target 0,0,1 --image closer.png", "from elsewhere"),
        ("room.ply --turntable 120 --image turn.gif --background 1", "a film from all around, before white"),
        ("room.ply --gaussians room.glb", "for viewers of Gaussian splatting"),
    ),
    "relight": (
        ("room.toml --path lamps.toml --image lamps.gif --direct traced", "a film of lamps that move"),
        ("room.toml --save room.transfer", "the seconds once; then `surflux relight room.transfer`"),
        ("scene.toml --environment hall.hdr --export scene.html", "a page whose slider turns the environment"),
    ),
    "solar": (
        ("roofs.laz --year 2025", "a year under clear skies, at the place that the file tells"),
        ("roofs.ply --epw city.epw --unit 0.3048", "a typical year's weather, coordinates in feet"),
    ),
    "view": (
        ("room.toml", "solve a scene and look at it; h lists the keys"),
        ("scan.ply --color normal --screenshot normals.png", "which way normals face"),
        ("scan_solved.ply --export scan.html", "a page that any browser shows"),
    ),
    "bench": (
        ("", "every pass, minutes"),
        ("--quick --plot curves.png", "error against seconds"),
    ),
    "info": (("", "versions, OpenGL, threads"), ("--json", "the same for programs")),
    "completion": (
        ("bash > ~/.local/share/bash-completion/completions/surflux", "for all new shells of bash"),
        ('zsh > "${fpath[1]}/_surflux"', "for zsh, where that folder is yours"),
        ("fish > ~/.config/fish/completions/surflux.fish", "for fish"),
    ),
}


def epilog(name):
    """The examples of a command as text, for argparse's RawDescriptionHelpFormatter."""
    lines = [f"surflux {name} {arguments}".rstrip() for arguments, _ in EXAMPLES[name]]
    told = [f"  {line}\n      {what}" for line, (_, what) in zip(lines, EXAMPLES[name], strict=True)]
    return "\n".join(["examples:", *told])
