#include "ply_samples.h"

#include <cmath>
#include <iterator>

namespace surflux {
namespace {

std::vector<PlyElement> quad_elements() {
    PlyElement vertex{"vertex", 4, {}}, face{"face", 2, {}}, more{"more", 1, {}};
    vertex.columns = {{"x", PlyType::float64, {0.1, 1e300, -0.0, 4}},
                      {"y", PlyType::float32, {0.1, 2, 3, 4}},
                      {"z", PlyType::int16, {-32768, 0, 1, 32767}},
                      {"red", PlyType::uint8, {0, 1, 254, 255}}};
    face.columns = {{"surfel", PlyType::int32, {-7, 2147483647}}};
    more.columns = {
        {"a", PlyType::uint32, {4294967295.0}}, {"b", PlyType::int8, {-128}}, {"c", PlyType::uint16, {65535}}};
    return {vertex, face, more};
}

TEST_F(Ply, WrittenFilesReadBack) {
    Polygons faces;
    faces.begin = {0, 4, 7};
    faces.corners = {0, 1, 2, 3, 2, 1, 0};
    std::vector<PlyElement> elements = quad_elements();
    write_ply(path(), elements, faces, {"one", "two {3}"});
    const PlyData data = read_ply(path(), {"vertex", "face", "more"});
    EXPECT_EQ(data.comments, (std::vector<std::string>{"one", "two {3}"}));
    EXPECT_EQ(data.faces.begin, faces.begin);
    EXPECT_EQ(data.faces.corners, faces.corners);
    elements[0].columns[1].values[0] = 0.1f;
    for (const PlyElement& e : elements)
        for (const PlyColumn& c : e.columns) EXPECT_EQ(column(data, e.name, c.name), c.values) << c.name;
    // The file and nothing else is in the folder.
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(Ply, AFaceMayHaveMoreCornersThanAByteCounts) {
    PlyElement vertex{"vertex", 300, {{"x", PlyType::float32, std::vector<double>(300)}}};
    Polygons faces;
    for (std::uint32_t i = 0; i < 300; ++i) faces.corners.push_back(i);
    faces.begin = {0, 300};
    write_ply(path(), {vertex, {"face", 1, {}}}, faces, {});
    EXPECT_EQ(read_ply(path()).faces.corners, faces.corners);
}

TEST_F(Ply, TheWriterRefusesWhatPlyCannotHold) {
    const auto text = [this](std::vector<PlyElement> elements, Polygons faces = {},
                             std::vector<std::string> comments = {}) {
        try {
            write_ply(path(), elements, faces, comments);
        } catch (const ArgumentError& e) {
            EXPECT_FALSE(fs::exists(path()));
            return std::string(e.what());
        }
        return std::string("no error");
    };
    const PlyElement good{"vertex", 1, {{"x", PlyType::float32, {0}}}};
    EXPECT_EQ(text({{"my vertex", 0, {}}}),
              "element: 'my vertex' cannot be a name in a PLY file (ASCII without blanks)");
    EXPECT_EQ(text({{"vertex", 0, {{"", PlyType::float32, {}}}}}),
              "column: '' cannot be a name in a PLY file (ASCII without blanks)");
    EXPECT_EQ(text({{"vertex", 2, {{"x", PlyType::float32, {0}}}}}), "column x: 1 values for 2 rows of vertex");
    EXPECT_EQ(text({{"vertex", 1, {{"x", PlyType::uint8, {256}}}}}), "column x[0]: 256 does not fit the type uchar");
    EXPECT_EQ(text({{"vertex", 1, {{"x", PlyType::uint8, {0.5}}}}}), "column x[0]: 0.5 does not fit the type uchar");
    EXPECT_EQ(text({{"vertex", 1, {{"x", PlyType::uint8, {std::nan("")}}}}}),
              "column x[0]: nan does not fit the type uchar");
    EXPECT_EQ(text({{"vertex", 1, {good.columns[0], good.columns[0]}}}), "column x: given twice");
    EXPECT_EQ(text({good, good}), "element vertex: given twice");
    EXPECT_EQ(text({good}, {{0, 1}, {0}}), "faces: 1 polygons for 0 rows of the element face");
    EXPECT_EQ(text({good, {"face", 1, {}}}, {{0, 2}, {0}}),
              "faces: offsets must ascend from 0 to the number of corners");
    EXPECT_EQ(text({good, {"face", 1, {}}}, {{0, 1}, {1}}), "faces: corner 1 of 1 vertices");
    EXPECT_EQ(text({good}, {}, {"a\nb"}), "comments: one line each, got 'a\\x0ab'");
    EXPECT_THROW(ply_type("bool"), ArgumentError);
}

TEST_F(Ply, TheWriterExplainsWhatTheDiskRefuses) {
    const PlyElement good{"vertex", 1, {{"x", PlyType::float32, {0}}}};
    const auto text = [&](const std::string& to) {
        try {
            write_ply(to, {good}, {}, {});
        } catch (const FileError& e) {
            return std::string(e.what());
        }
        return std::string("no error");
    };
    EXPECT_EQ(text(path("no/such/folder.ply")),
              path("no/such/folder.ply") + ": cannot be written: there is no folder " + path("no/such"));
    EXPECT_EQ(text(folder_.string()), folder_.string() + ": is a folder, not a file");
    if (fs::exists("/dev/full")) {
        EXPECT_EQ(text("/dev/full"), "/dev/full: cannot be written (No space left on device)");
    }
    EXPECT_EQ(text("/dev/null"), "no error");
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Ply, WritingReplacesAFileAndKeepsALink) {
    const PlyElement good{"vertex", 1, {{"x", PlyType::float32, {0}}}};
    file("something else", "old.ply");
    fs::create_symlink("old.ply", path("link.ply"));
    write_ply(path("link.ply"), {good}, {}, {});
    EXPECT_TRUE(fs::is_symlink(path("link.ply")));
    EXPECT_EQ(read_ply(path("old.ply")).find("vertex")->count, 1u);
}

}  // namespace
}  // namespace surflux
