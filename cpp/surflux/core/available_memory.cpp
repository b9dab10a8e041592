#include "surflux/core/available_memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#ifdef __GLIBC__  // known once a header of the library was read
#include <malloc.h>
#endif

namespace surflux {

namespace {

namespace fs = std::filesystem;

constexpr double unlimited = std::numeric_limits<double>::infinity();

// The first number in a file; `otherwise` where there is none, as in memory.max, which may say "max".
double number_in(const fs::path& path, double otherwise) {
    std::ifstream in(path);
    double value = 0.0;
    return in >> value ? value : otherwise;
}

// The number behind `key` in a file of lines "key number".
double number_of(const std::string& key, const fs::path& path) {
    std::ifstream in(path);
    std::string name;
    for (double value = 0.0; in >> name >> value;)
        if (name == key) return value;
    return 0.0;
}

// One version's files, by name.
struct Group {
    const char *limit, *used, *cache;
};
constexpr Group version_1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"};
constexpr Group version_2{"memory.max", "memory.current", "inactive_file"};

// What is left in a group and in those around it. In a container the path may be that outside of it, of which only the
// end of the walk is there, its own group.
double left_in_groups(const fs::path& mount, const std::string& group, const Group& files) {
    double left = unlimited;
    for (fs::path inner = fs::path(group).relative_path();; inner = inner.parent_path()) {
        const fs::path folder = mount / inner;
        if (const double limit = number_in(folder / files.limit, unlimited); limit < unlimited) {
            const double used = number_in(folder / files.used, 0.0);
            left = std::min(left, limit - used + number_of(files.cache, folder / "memory.stat"));
        }
        if (inner.empty()) return left;
    }
}

double left_in_groups(const std::string& root) {
    double left = unlimited;
    std::ifstream in(root + "/proc/self/cgroup");
    for (std::string line; std::getline(in, line);) {  // number:controllers:path; version 2 has no controllers
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) continue;
        const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",",
                          path = line.substr(second + 1);
        if (controllers == ",,") {
            // Beside version 1 it is mounted apart.
            for (const char* mount : {"/sys/fs/cgroup", "/sys/fs/cgroup/unified"})
                left = std::min(left, left_in_groups(root + mount, path, version_2));
        } else if (controllers.find(",memory,") != std::string::npos) {
            left = std::min(left, left_in_groups(root + "/sys/fs/cgroup/memory", path, version_1));
        }
    }
    return left;
}

double left_of_address_space(const std::string& root) {
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
    const double pages = number_in(root + "/proc/self/statm", 0.0);
    return static_cast<double>(limit.rlim_cur) - pages * static_cast<double>(sysconf(_SC_PAGE_SIZE));
}

}  // namespace

double available_memory(const std::string& root) {
    const double machine = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
    return std::max(0.0, std::min({machine, left_in_groups(root), left_of_address_space(root)}));
}

void give_back_memory() {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

}  // namespace surflux
