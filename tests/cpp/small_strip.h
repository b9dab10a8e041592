#pragma once

#include "shapes.h"

namespace surflux {

// A floor (object 0), and above it a black ceiling, beside which a strip (object 1) of 1 by 20 cm is bright.
inline Scene small_strip() {
    Surfels floor, strip, ceiling;
    shapes::add_rectangle(floor, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 20, 20);
    shapes::add_rectangle(strip, {0.6, 0.4, 0.5}, {0, 0.2, 0}, {0.01, 0, 0}, 4, 1);
    shapes::add_rectangle(ceiling, {0, 0, 0.5}, {0, 1, 0}, {0.6, 0, 0}, 4, 4);
    for (Surfels* s : {&floor, &strip, &ceiling}) shapes::finish(*s, 0.5, 0.0);
    return shapes::scene_of({floor, strip, ceiling});
}

}  // namespace surflux
