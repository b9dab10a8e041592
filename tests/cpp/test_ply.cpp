#include "ply_samples.h"

#include <limits>
#include <sstream>

namespace surflux {
namespace {

void expect_binary_file(const PlyData& data) {
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(column(data, "vertex", "x")[i], 5e6 + 0.001 * double(i));
        EXPECT_EQ(column(data, "vertex", "y")[i], 0.25 * double(i));
        EXPECT_EQ(column(data, "vertex", "z")[i], -300.0 - double(i));
        EXPECT_EQ(column(data, "vertex", "id")[i], 4e9 + double(i));
    }
    EXPECT_EQ(data.faces.begin, (std::vector<std::size_t>{0, 4, 7}));
    EXPECT_EQ(data.faces.corners, (std::vector<std::uint32_t>{0, 1, 2, 3, 3, 2, 1}));
    EXPECT_EQ(column(data, "face", "flags"), (std::vector<double>{9, 9}));
    EXPECT_TRUE(data.find("junk")->columns.empty());
    EXPECT_EQ(data.find("junk")->count, 2u);
}

TEST_F(Ply, ReadsAscii) {
    const PlyData data = read(triangle);
    EXPECT_EQ(column(data, "vertex", "x"), (std::vector<double>{0, 1.5, 0}));
    EXPECT_EQ(column(data, "vertex", "z"), (std::vector<double>{0.5, -20, 3}));
    EXPECT_EQ(column(data, "vertex", "red"), (std::vector<double>{255, 0, 7}));
    EXPECT_EQ(data.find("vertex")->columns[2].type, PlyType::float64);
    EXPECT_EQ(data.faces.corners, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(data.comments, (std::vector<std::string>{"made by hand"}));
    EXPECT_EQ(data.object_info, (std::vector<std::string>{"scanner 7"}));
}

TEST_F(Ply, ReadsAsciiWithAnyNewlineBlankLinesAndTabs) {
    for (const std::string newline : {"\r\n", "\r"}) {
        const PlyData data = read(replaced(triangle, "\n", newline));
        EXPECT_EQ(column(data, "vertex", "y"), (std::vector<double>{0, 0, 1}));
        EXPECT_EQ(data.comments, (std::vector<std::string>{"made by hand"}));
    }
    std::string loose = replaced(replaced(triangle, " ", " \t "), "\n", " \n\n");
    loose.replace(loose.find("ply \n\n"), 6, "ply \n");
    EXPECT_EQ(read(loose).faces.corners.size(), 3u);
    EXPECT_EQ(read(triangle.substr(0, triangle.size() - 1)).faces.size(), 1u);  // no newline at the end
}

TEST_F(Ply, ReadsBothByteOrdersWithAnyElementAndPropertyOrder) {
    for (const bool big : {false, true})
        for (const std::string newline : {"\n", "\r\n", "\r"}) expect_binary_file(read(binary_file(big, newline)));
}

TEST_F(Ply, ReadsTexcoordOfFaces) {
    const PlyData data = read(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nelement face 2\n"
        "property list uchar float texcoord\nproperty list uchar int vertex_indices\nend_header\n"
        "0\n1\n2\n6 0 .25 1 0 nan 1 3 0 1 2\n0 3 2 1 0\n");
    EXPECT_EQ(data.texcoord.begin, (std::vector<std::size_t>{0, 6, 6}));
    EXPECT_EQ(data.texcoord.values[1], 0.25);
    EXPECT_EQ(data.faces.corners, (std::vector<std::uint32_t>{0, 1, 2, 2, 1, 0}));
}

TEST_F(Ply, ReadsEveryTypeByBothNames) {
    const std::vector<std::vector<std::string>> names{{"char", "int8"},     {"uchar", "uint8"},   {"short", "int16"},
                                                      {"ushort", "uint16"}, {"int", "int32"},     {"uint", "uint32"},
                                                      {"float", "float32"}, {"double", "float64"}};
    const std::vector<double> values{-128, 255, -32768, 65535, -2147483648.0, 4294967295.0, -0.15625, 1e-300};
    for (std::size_t t = 0; t < names.size(); ++t) {
        for (const std::string& name : names[t]) {
            const std::string properties = "element vertex 1\nproperty " + name + " v\nend_header\n";
            std::ostringstream text;
            text.precision(17);
            text << "ply\nformat ascii 1.0\n" << properties << values[t] << "\n";
            EXPECT_EQ(column(read(text.str()), "vertex", "v")[0], values[t]) << name;
            for (const bool big : {false, true}) {
                std::string b =
                    std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\n" + properties;
                switch (t) {
                    case 0:
                        put(b, std::int8_t(-128), big);
                        break;
                    case 1:
                        put(b, std::uint8_t(255), big);
                        break;
                    case 2:
                        put(b, std::int16_t(-32768), big);
                        break;
                    case 3:
                        put(b, std::uint16_t(65535), big);
                        break;
                    case 4:
                        put(b, std::numeric_limits<std::int32_t>::min(), big);
                        break;
                    case 5:
                        put(b, std::numeric_limits<std::uint32_t>::max(), big);
                        break;
                    case 6:
                        put(b, -0.15625f, big);
                        break;
                    default:
                        put(b, 1e-300, big);
                        break;
                }
                const PlyData data = read(b);
                EXPECT_EQ(column(data, "vertex", "v")[0], values[t]) << name << big;
                EXPECT_STREQ(name_of(data.find("vertex")->columns[0].type), names[t][0].c_str());
            }
        }
    }
}

TEST_F(Ply, AnAsciiNumberMustFitItsType) {
    EXPECT_EQ(refusal(replaced(triangle, " 255", " 256")),
              " (line 13): vertex 0: 'red' is '256', which its type uchar does not hold");
    EXPECT_EQ(refusal(replaced(triangle, " 255", " 2.5")),
              " (line 13): vertex 0: 'red' is '2.5', which its type uchar does not hold");
    EXPECT_EQ(column(read(replaced(triangle, " 255", " 255.0")), "vertex", "red")[0], 255.0);
    EXPECT_EQ(column(read(replaced(triangle, "1.5", "1e-999")), "vertex", "x")[1], 0.0);
}

TEST_F(Ply, NamesTheLineOfBadAsciiData) {
    EXPECT_EQ(refusal(replaced(triangle, "1.5", "1,5")), " (line 14): vertex 1: 'x' is '1,5', which is no number");
    EXPECT_EQ(refusal(replaced(triangle, "1.5", "\xff\x01")),
              " (line 14): vertex 1: 'x' is '\\xff\\x01', which is no number");
    EXPECT_EQ(refusal(replaced(triangle, "+3 7", "+3")), " (line 15): vertex 2 ends before 'red'");
    EXPECT_EQ(refusal(replaced(triangle, "+3 7", "+3 7 8")),
              " (line 15): vertex 2 goes on with '8' after its last property 'red'");
    EXPECT_EQ(refusal(replaced(triangle, "3 0 1 2", "3 0 1")), " (line 16): face 0 ends before 'vertex_indices'");
    EXPECT_EQ(refusal(replaced(triangle, "3 0 1 2", "3 0 1 3")),
              " (line 16): face 0 has the corner 3; the file has 3 vertices, numbered from 0");
    EXPECT_EQ(refusal(replaced(triangle, "3 0 1 2", "3 0 1 -1")),
              " (line 16): face 0 has the corner -1; the file has 3 vertices, numbered from 0");
    EXPECT_EQ(
        refusal(replaced(triangle, "3 0 1 2\n", "")),
        " (line 16): truncated: the header promises 1 of element 'face', at least 2 bytes each, but 0 bytes are left "
        "in the file");
    EXPECT_EQ(refusal(triangle + "4\n"),
              " (line 17): the file goes on after all that its header promises; a count or a type there is wrong");
    for (const char* value : {"inf", "-inf", "nan", "+inf", "1e999"})
        EXPECT_NE(refusal(replaced(triangle, "1.5", value)).find(" (line 14): vertex 1: x is "), std::string::npos);
    const std::string negative = replaced(replaced(triangle, "list uchar", "list char"), "3 0 1 2", "-1");
    EXPECT_EQ(refusal(negative), " (line 16): face 0: 'vertex_indices' has -1 entries");
}

TEST_F(Ply, NamesTheByteOfBadBinaryData) {
    const std::string h = "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nend_header\n";
    std::string b = h;
    put(b, 1.0f, false);
    EXPECT_EQ(refusal(b), message(" (byte ", h.size(),
                                  "): truncated: the header promises 2 of element 'vertex', at least 4 "
                                  "bytes each, but 4 bytes are left in the file"));
    std::string nan = b;
    put(nan, std::numeric_limits<float>::infinity(), false);
    EXPECT_EQ(refusal(nan), message(" (byte ", h.size() + 4, "): vertex 1: x is inf; wanted a finite number"));
    put(b, 1.0f, false);
    EXPECT_EQ(read(b + "\n").find("vertex")->count, 2u);  // a newline at the end does no harm
    EXPECT_EQ(refusal(b + "x"), message(" (byte ", b.size(),
                                        "): the file goes on after all that its header promises; a count "
                                        "or a type there is wrong"));
    std::string faces = replaced(b, "end_header", "element face 1\nproperty list int int vertex_index\nend_header");
    const std::size_t begin = faces.size();
    std::string few = faces, far = faces, negative = faces;
    put(few, std::int32_t(1000000000), false);
    put(few, std::int32_t(1), false);
    EXPECT_EQ(refusal(few), message(" (byte ", begin + 4,
                                    "): truncated: face 0 needs 4000000000 more bytes, but 4 are left in "
                                    "the file"));
    put(far, std::int32_t(1), false);
    put(far, std::int32_t(2), false);
    EXPECT_EQ(refusal(far),
              message(" (byte ", begin, "): face 0 has the corner 2; the file has 2 vertices, numbered from 0"));
    put(negative, std::int32_t(-5), false);
    EXPECT_EQ(refusal(negative), message(" (byte ", begin, "): face 0: 'vertex_index' has -5 entries"));
}

TEST_F(Ply, BelievesNoCount) {
    for (const std::string count : {"100000000000", "18446744073709551615", "4611686018427387905"}) {
        for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
            for (const std::string property :
                 {"property double x\n", "property list uchar double l\nproperty double x\n"}) {
                const std::string text = refusal("ply\nformat " + format + " 1.0\nelement vertex " + count + "\n" +
                                                 property + "end_header\n1 2 3 4 5 6 7 8\n");
                EXPECT_NE(text.find("truncated: the header promises " + count), std::string::npos) << text;
            }
        }
    }
    // Rows of nothing take no room, however many.
    EXPECT_EQ(read("ply\nformat ascii 1.0\nelement nothing 100000000000\nend_header\n").find("nothing")->count,
              100000000000u);
}

TEST_F(Ply, ExplainsABadHeader) {
    const auto header = [this](const std::string& lines) { return refusal("ply\nformat ascii 1.0\n" + lines); };
    EXPECT_EQ(refusal(""), ": the file is empty");
    EXPECT_EQ(refusal("plyx\n"), " (line 1): not a PLY file: the first line is not 'ply'");
    EXPECT_EQ(refusal("\n\nply\n"), " (line 1): not a PLY file: the first line is not 'ply'");
    EXPECT_EQ(refusal("version https://git-lfs.github.com/spec/v1\noid 1\n"),
              " (line 1): a pointer of git-lfs, not the file itself; 'git lfs pull' fetches that");
    EXPECT_EQ(refusal("ply"), " (line 1): the header ends before its end_header line");
    EXPECT_EQ(header(""), " (line 3): the header ends before its end_header line");
    EXPECT_EQ(
        header("element vertex 3\nend_head\n"),
        " (line 4): the header has a line that begins with 'end_head'; wanted comment, obj_info, element, property or "
        "end_header");
    EXPECT_EQ(refusal("ply\nelement vertex 0\nend_header\n"), " (line 3): the header has no format line");
    EXPECT_EQ(header("format ascii 1.0\n"), " (line 3): a second format line");
    EXPECT_EQ(refusal("ply\nformat text 1.0\n"),
              " (line 2): the format is 'text'; wanted ascii, binary_little_endian or binary_big_endian");
    EXPECT_EQ(refusal("ply\nformat ascii 2.0\n"), " (line 2): the format's version is '2.0'; wanted 1.0");
    EXPECT_EQ(header("property float x\n"), " (line 3): a property before any element");
    EXPECT_EQ(header("element vertex\n"), " (line 3): wanted 'element NAME COUNT'");
    for (const std::string count : {"-1", "x", "1.5", "18446744073709551616"})
        EXPECT_EQ(header("element vertex " + count + "\n"),
                  " (line 3): the count of element 'vertex' is '" + count + "'; wanted a whole number from 0");
    EXPECT_EQ(header("element vertex 1\nelement vertex 1\n"), " (line 4): a second element 'vertex'");
    EXPECT_EQ(header("element vertex 1\nproperty float x\nproperty int x\n"), " (line 5): a second property 'x'");
    EXPECT_EQ(header("element vertex 1\nproperty float\n"),
              " (line 4): wanted 'property TYPE NAME' or 'property list COUNT_TYPE TYPE NAME'");
    EXPECT_EQ(
        header("element vertex 1\nproperty bool b\n"),
        " (line 4): property 'b' has the unknown type 'bool'; wanted char, uchar, short, ushort, int, uint, float, "
        "double (or int8 ... float64)");
    EXPECT_EQ(header("element face 1\nproperty list float int l\n"),
              " (line 4): list property 'l' is counted in 'float'; wanted a type of integers");
    EXPECT_EQ(header("element face 0\nproperty list uchar float vertex_index\nend_header\n"),
              ": face corners (vertex_index) are of type float; wanted a type of integers");
}

TEST_F(Ply, ExplainsWhatIsNoFile) {
    const auto text = [](const std::string& path) {
        try {
            (void)read_ply(path);
        } catch (const FileError& e) {
            return std::string(e.what());
        }
        return std::string("no error");
    };
    EXPECT_EQ(text(path("missing.ply")), path("missing.ply") + ": no such file");
    EXPECT_EQ(text(folder_.string()), folder_.string() + ": is a folder, not a file");
    EXPECT_EQ(text("/dev/zero"), "/dev/zero: is not a regular file");
    EXPECT_EQ(text(path("bad\xff")), path("bad") + "\\xff: no such file");
}

}  // namespace
}  // namespace surflux
