#pragma once

#include <string>

#include "surflux/core/error.h"

namespace surflux {

// What the ArgumentError says that `call` throws; "none" where it throws none.
template <class Call>
std::string refusal(const Call& call) {
    try {
        call();
    } catch (const ArgumentError& error) {
        return error.what();
    }
    return "none";
}

}  // namespace surflux
