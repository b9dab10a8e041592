#pragma once

#include <string>

namespace surflux {

// Bytes that this process may still ask for: the machine's memory, or what is left of a lower limit, of its control
// groups (containers, batch queues; version 1 or 2) or of its address space (ulimit -v). Files that groups keep in
// memory only to have them at hand count as free. `root`: where /proc and /sys stand, for tests.
double available_memory(const std::string& root = "");

// Hands back to the system what the heap has free: after a pass with many small arrays on many threads glibc keeps it.
void give_back_memory();

}  // namespace surflux
