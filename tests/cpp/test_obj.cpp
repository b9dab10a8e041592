#include "surflux/files/obj.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "surflux/core/error.h"
#include "surflux/core/random.h"

namespace surflux {
namespace {

ObjData read(const std::string& text) { return parse_obj("a.obj", text); }

std::string refusal(const std::string& text) {
    try {
        (void)read(text);
    } catch (const FileError& e) {
        return std::string(e.what()).substr(5);  // after the path
    }
    return "no error";
}

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.1\n";

TEST(Obj, KeepsPolygonsWhateverTheWayOfIndexing) {
    const std::vector<std::uint32_t> quad{0, 1, 2, 3};
    for (const std::string face :
         {"f 1 2 3 4", "f 1/1 2/2 3/3 4/4", "f 1//1 2//1 3//1 4//1", "f 1/5/1 2/6/1 3/7/1 4/8/1", "f -4 -3 -2 -1",
          "f 1 2 \\\n 3\\\n 4", "  f\t1 2 3 4 # all of them\r"}) {
        const ObjData data = read("# a square\nmtllib a.mtl\nusemtl\n" + square + face + "\nvn 0 0 1\n");
        EXPECT_EQ(data.faces.corners, quad) << face;
        EXPECT_EQ(data.faces.size(), 1u);
        EXPECT_EQ(data.vertices[3].z, 0.1);
        EXPECT_TRUE(data.colors.empty());
    }
}

TEST(Obj, AFaceMayComeBeforeItsVertices) { EXPECT_EQ(read("f 1 2 3\n" + square).faces.corners.size(), 3u); }

TEST(Obj, FacesHaveTheMaterialOfTheLastName) {
    const ObjData data = read("\xef\xbb\xbfmtllib a  b.mtl \r\nmtllib c.mtl # more\nmtllib d.mtl \\\n e.mtl\n" +
                              square + "f 1 2 3\nusemtl red #1\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl red #1\nf 1 2 3\n");
    EXPECT_EQ(data.libraries, (std::vector<std::string>{"a  b.mtl", "c.mtl # more", "d.mtl  e.mtl"}));
    EXPECT_EQ(data.materials, (std::vector<std::string>{"red #1", "b"}));
    EXPECT_EQ(data.face_materials, (std::vector<std::uint32_t>{ObjData::no_material, 0, 1, 0}));
}

TEST(Obj, CommentsBehindNamesGoOnToNoOtherLine) {
    const ObjData data =
        read("mtllib a.mtl # of C:\\work\\\n" + square + "usemtl red\t# C:\\lib\\\nf 1 2 3\nusemtl #\\\nf 1 2 4\n");
    EXPECT_EQ(data.vertices.size(), 4u);
    EXPECT_EQ(data.faces.size(), 2u);
    EXPECT_EQ(data.libraries, (std::vector<std::string>{"a.mtl # of C:\\work\\"}));
}

TEST(Obj, VerticesHaveColorsOrNaN) {
    const ObjData data = read("v 0 0 0 .25 .5 1\nv 1 0 0\nv 1 0 0 0 0 0\n");
    EXPECT_EQ(data.colors.at(0).y, 0.5);
    EXPECT_TRUE(std::isnan(data.colors.at(1).x) && std::isnan(data.colors.at(1).z));
    EXPECT_EQ(data.colors.at(2).z, 0.0);
    EXPECT_TRUE(read("v 0 0 0\n").colors.empty());
    EXPECT_TRUE(read("v 0 0 0 1\n").colors.empty());  // a weight
}

TEST(Obj, NamesTheLine) {
    EXPECT_EQ(refusal(square + "f 1 2\n"), " (line 5): a face of 2 corners; wanted 3 or more");
    EXPECT_EQ(refusal(square + "f 1 2 5\n"), " (line 5): a face has the corner 5, but the file has 4 vertices");
    EXPECT_EQ(refusal(square + "f 1 2 0\n"), " (line 5): a face has the corner 0 after 4 vertices");
    EXPECT_EQ(refusal(square + "f 1 2 -5\n"), " (line 5): a face has the corner -5 after 4 vertices");
    EXPECT_EQ(refusal(square + "f 1 2 99999999999\n"), " (line 5): a face has the corner 99999999999 after 4 vertices");
    EXPECT_EQ(refusal(square + "f 1 2 a\n"),
              " (line 5): 'a' is no corner of a face; wanted an index as in 7, 7/1, 7//2 or 7/1/2");
    EXPECT_EQ(refusal("v 0 0\n"), " (line 1): a vertex of 2 numbers; wanted 3 coordinates");
    EXPECT_EQ(refusal("\n\nv 0 0 3.1+e2\n"), " (line 3): '3.1+e2' is no number");
    EXPECT_EQ(refusal("v 0 0 nan\n"), " (line 1): a coordinate is not finite");
    EXPECT_EQ(refusal("v 0 0 1e999\n"), " (line 1): a coordinate is not finite");
}

TEST(Obj, CornersHavePlacesOnTextures) {
    const ObjData data = read(square + "vt .5 .25 1\nvt 1e99 x\nvt 2\nf 1/1 2/2/7 3/-1\nf 1 2//1 3/\nf 1/4 2/-4 3/0\n");
    ASSERT_EQ(data.texture_places.size(), 3u);
    const float wanted[][2] = {{0.5f, 0.25f}, {0.0f, 0.0f}, {2.0f, 0.0f}};
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(data.texture_places[k].u, wanted[k][0]);
        EXPECT_EQ(data.texture_places[k].v, wanted[k][1]);
    }
    const std::uint32_t none = ObjData::no_place;
    EXPECT_EQ(data.texture_corners, (std::vector<std::uint32_t>{0, 1, 2, none, none, none, none, none, none}));
    EXPECT_TRUE(read(square + "f 1/1 2/2 3/3\n").texture_corners.empty());
    // A face may come before its places.
    EXPECT_EQ(read(square + "f 1/2 2/1 3/3\nvt 0 0\nvt 0 1\n").texture_corners,
              (std::vector<std::uint32_t>{1, 0, none}));
}

TEST(Obj, ReadsFromDisk) {
    const std::string path =
        (std::filesystem::temp_directory_path() / ("surflux_" + std::to_string(::getpid()) + ".obj")).string();
    std::ofstream(path, std::ios::binary) << square << "f 1 2 3 4\n";
    EXPECT_EQ(read_obj(path).faces.size(), 1u);
    std::filesystem::remove(path);
    EXPECT_THROW(read_obj(path), FileError);
}

TEST(Obj, MutatedFilesGiveDataOrAFileError) {
    const std::string seed = "mtllib a\n" + square + "f 1/1/1 2//2 -2 \\\n4\nf 1 2 3\n";
    Random random(2);
    int refused = 0, accepted = 0;
    for (int trial = 0; trial < 3000; ++trial) {
        std::string text = seed;
        for (std::uint64_t k = 0, changes = 1 + random.below(3); k < changes; ++k)
            text[random.below(text.size())] = "\\/-#\n 0v9f\xff"[random.below(11)];
        text.resize(1 + random.below(text.size() * 2));
        try {
            const ObjData data = read(text);
            for (const std::uint32_t corner : data.faces.corners) ASSERT_LT(corner, data.vertices.size());
            ++accepted;
        } catch (const FileError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 300);
    EXPECT_GT(accepted, 300);
}

}  // namespace
}  // namespace surflux
