#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

#include "surflux/core/available_memory.h"

namespace surflux {
namespace {

namespace fs = std::filesystem;

constexpr double megabyte = 1048576.0;

// A root with /proc and /sys of a machine that is not this one.
class AvailableMemory : public testing::Test {
protected:
    AvailableMemory()
        : root_(fs::path(testing::TempDir()) / ("surflux_available_memory" + std::to_string(::getpid()))) {
        fs::remove_all(root_);
    }
    ~AvailableMemory() override { fs::remove_all(root_); }

    void write(const std::string& path, const std::string& text) const {
        fs::create_directories((root_ / path).parent_path());
        std::ofstream(root_ / path) << text;
    }
    double found() const { return available_memory(root_.string()) / megabyte; }

    fs::path root_;
};

TEST_F(AvailableMemory, WithoutLimitsIsThatOfTheMachine) {
    const double machine = found();  // nothing at all is there
    EXPECT_GT(machine, 64.0);
    write("proc/self/cgroup", "0::/user/job\n");
    write("sys/fs/cgroup/user/job/memory.max", "max\n");
    write("sys/fs/cgroup/user/job/memory.current", "1000000\n");
    EXPECT_EQ(found(), machine);
    write("proc/self/cgroup", "no line of a kind that is known\n");
    EXPECT_EQ(found(), machine);
}

TEST_F(AvailableMemory, IsWhatIsLeftOfTheTightestGroup) {
    write("proc/self/cgroup", "0::/queue/job/step\n");
    write("sys/fs/cgroup/queue/job/memory.max", "67108864\n");  // 64 MB, and no limit of the step's own
    write("sys/fs/cgroup/queue/job/memory.current", "25165824\n");
    EXPECT_EQ(found(), 40.0);
    write("sys/fs/cgroup/queue/job/memory.stat", "anon 16777216\ninactive_file 8388608\n");
    EXPECT_EQ(found(), 48.0);  // files can be let go
    write("sys/fs/cgroup/queue/memory.max", "33554432\n");
    write("sys/fs/cgroup/queue/memory.current", "25165824\n");
    EXPECT_EQ(found(), 8.0);
    write("sys/fs/cgroup/queue/memory.current", "50331648\n");  // a limit lowered below what is used
    EXPECT_EQ(found(), 0.0);
}

TEST_F(AvailableMemory, OfAContainerIsThatAtItsRoot) {
    write("proc/self/cgroup", "0::/\n");
    write("sys/fs/cgroup/memory.max", "33554432\n");
    write("sys/fs/cgroup/memory.current", "1048576\n");
    EXPECT_EQ(found(), 31.0);
    write("proc/self/cgroup", "0::/docker/4f2a\n");  // named as outside, mounted as inside
    EXPECT_EQ(found(), 31.0);
}

TEST_F(AvailableMemory, KnowsControlGroupsOfVersionOne) {
    write("proc/self/cgroup", "12:cpu,cpuacct:/a\n9:memory:/slurm/job\n1:name=systemd:/b\n0::/c\n");
    write("sys/fs/cgroup/memory/slurm/job/memory.limit_in_bytes", "67108864\n");
    write("sys/fs/cgroup/memory/slurm/job/memory.usage_in_bytes", "16777216\n");
    write("sys/fs/cgroup/memory/slurm/job/memory.stat", "cache 1\ntotal_inactive_file 4194304\n");
    write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");  // none
    EXPECT_EQ(found(), 52.0);
}

TEST_F(AvailableMemory, IsLessThanALimitOfAddressSpace) {
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
    const double limit = before.rlim_max == RLIM_INFINITY ? 1e15 : static_cast<double>(before.rlim_max);
    rlimit wide = before;
    wide.rlim_cur = static_cast<rlim_t>(limit);
    ASSERT_EQ(setrlimit(RLIMIT_AS, &wide), 0);
    // All of it but 3 MB is in use.
    const auto page = static_cast<double>(sysconf(_SC_PAGE_SIZE));
    const auto pages = static_cast<long long>((limit - 3.0 * megabyte) / page);
    write("proc/self/statm", std::to_string(pages) + " 7 7 7 0 7 0\n");
    const double left = found();
    setrlimit(RLIMIT_AS, &before);
    EXPECT_NEAR(left, 3.0, page / megabyte);
}

}  // namespace
}  // namespace surflux
