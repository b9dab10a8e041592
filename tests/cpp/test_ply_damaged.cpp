#include "ply_samples.h"
#include "surflux/core/random.h"

namespace surflux {
namespace {

TEST_F(Ply, ABinaryFileCutAnywhereIsRefused) {
    for (const bool big : {false, true}) {
        const std::string whole = binary_file(big, "\r\n");
        for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_NE(refusal(whole.substr(0, size)), "") << size;
    }
}

TEST_F(Ply, AnAsciiFileCutAnywhereIsRefused) {
    // The last characters are "3 0 1 2\n": without the newline the file is still whole.
    for (std::size_t size = 0; size + 1 < triangle.size(); ++size)
        EXPECT_NE(refusal(triangle.substr(0, size)), "") << size;
}

TEST_F(Ply, AHeaderOfManyNamesTakesNoLongerPerName) {
    // Comparing each name with each other would take minutes.
    std::string header = "ply\nformat ascii 1.0\n";
    for (int i = 0; i < 200000; ++i) header += message("element e", i, " 0\n");
    for (int i = 0; i < 200000; ++i) header += message("property int p", i, "\n");
    EXPECT_EQ(read(header + "end_header\n").elements.size(), 200000u);
}

TEST_F(Ply, MutatedFilesGiveDataOrAFileError) {
    std::vector<std::string> seeds{triangle, binary_file(false, "\n"), binary_file(true, "\r\n")};
    Random random(1);
    const std::vector<std::string> pieces{
        "999999999999", "-1",    "nan",          "list",  "property",           "element",         "\n", " ", "\r",
        "double",       "uchar", "end_header\n", "1e999", std::string(3, '\0'), "\xff\xff\xff\xff"};
    int refused = 0, accepted = 0;
    for (int trial = 0; trial < 6000; ++trial) {
        std::string bytes = seeds[random.below(seeds.size())];
        for (std::uint64_t k = 0, changes = 1 + random.below(3); k < changes; ++k) {
            // Half of them behind the header, whose every letter counts.
            const std::size_t header = bytes.find("end_header");
            const std::size_t body = header < bytes.size() && random.below(2) ? header : 0;
            const std::size_t at = body + random.below(bytes.size() - body);
            const std::string& piece = pieces[random.below(pieces.size())];
            switch (random.below(5)) {
                case 0:
                    bytes[at] = static_cast<char>(random.below(256));
                    break;
                case 1:
                    bytes.insert(at, piece);
                    break;
                case 2:
                    bytes.erase(at, 1 + random.below(8));
                    break;
                case 3:
                    bytes.replace(at, std::min(piece.size(), bytes.size() - at), piece);
                    break;
                default:
                    bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
                    break;
            }
            if (bytes.empty()) bytes = "p";
        }
        try {
            const PlyData data = read(bytes);
            ++accepted;
            for (const PlyElement& e : data.elements)
                for (const PlyColumn& c : e.columns) ASSERT_EQ(c.values.size(), e.count);
            ASSERT_EQ(data.faces.begin.back(), data.faces.corners.size());
            for (const std::uint32_t corner : data.faces.corners) ASSERT_LT(corner, data.find("vertex")->count);
        } catch (const FileError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 1000);
    EXPECT_GT(accepted, 500);
}

}  // namespace
}  // namespace surflux
