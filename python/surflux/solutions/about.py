"""What a file says of a solution as a whole."""


def about_solution(solution):
    """A dict for `pack_comments`: figures, camera and lamps."""
    lamps = [[list(v) for v in (lamp.corner, lamp.edge_u, lamp.edge_v, lamp.exitance)] for lamp in solution._lamps]
    return {
        "solution": 1,
        "error": solution.error,
        "timings": solution.timings,
        "history": solution.history,
        "attempts": solution.attempts,
        "camera": None if solution.camera is None else solution.camera.to_dict(),
        "lamps": lamps,
    }
