// 3MF files by hand: units, transforms, components, colours; every fault with its line and object; bombs.

#include "pathgen/part_file/three_mf.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/part_file/zip_archive.h"
#include "tests/texts/zip_text.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

Result<PartModel> read_model(const std::string& resources, const std::string& build,
                             const std::string& attributes = "") {
  return parse_three_mf(three_mf_of(mf_model(resources, build, attributes)), "f.3mf");
}
std::string corner_object(const std::string& more = "name=\"corner\"") {
  return "<object id=\"1\" " + more + ">" + kMfCorner + "</object>\n";
}

void expect_mf_refused(const Result<PartModel>& read, Code code, const std::string& piece) {
  ASSERT_FALSE(read) << "accepted; expected: " << piece;
  EXPECT_EQ(read.error().code, code) << read.error().message;
  EXPECT_NE(read.error().message.find(piece), std::string::npos)
      << read.error().message << "\nlacks: " << piece;
}

double volume_of(const PartModel& model) {
  const auto checked = check_mesh(model.mesh, {0.0});
  EXPECT_TRUE(checked);
  if (!checked) return 0.0;
  EXPECT_EQ(checked->sides, Sides::kOutward);
  EXPECT_TRUE(checked->defects.empty());
  return checked->volume;
}

TEST(ThreeMf, UnitsBecomeMillimetres) {
  const std::pair<const char*, double> units[] = {{"micron", 1e-3}, {"millimeter", 1.0}, {"centimeter", 10.0},
                                                  {"inch", 25.4},   {"foot", 304.8},     {"meter", 1000.0}};
  for (const auto& [unit, mm] : units) {
    const auto read =
        read_model(corner_object(), "<item objectid=\"1\"/>", std::string("unit=\"") + unit + "\"");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->unit, unit);
    EXPECT_EQ(read->unit_mm, mm);
    EXPECT_EQ(read->mesh.facets.size(), 4u);
    EXPECT_DOUBLE_EQ(read->mesh.facets[0][2].x, mm);
    EXPECT_NEAR(volume_of(*read), mm * mm * mm / 6.0, 1e-12 * mm * mm * mm);
  }
  EXPECT_EQ(read_model(corner_object(), "<item objectid=\"1\"/>")->unit_mm, 1.0);
  expect_mf_refused(read_model(corner_object(), "<item objectid=\"1\"/>", "unit=\"yard\""), Code::kInput,
                    "'yard' is no unit of 3MF");
}

/// A corner turned by 90 degrees about z, then moved; the item moves it once more. By hand: x = -y + 10 +
/// 100.
TEST(ThreeMf, ComponentsThenItems) {
  const auto read = read_model(corner_object() +
                                   "<object id=\"5\" name=\"pair\"><components>"
                                   "<component objectid=\"1\" transform=\"0 1 0 -1 0 0 0 0 1 10 20 30\"/>"
                                   "<component objectid=\"1\"/></components></object>",
                               "<item objectid=\"5\" transform=\"1 0 0 0 1 0 0 0 1 100 200 300\"/>");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->bodies.size(), 2u);
  EXPECT_EQ(read->bodies[0].name, "corner");
  EXPECT_EQ(read->bodies[1].name, "corner (2)");
  EXPECT_EQ(read->bodies[0].product, "pair");
  const auto expect_at = [&](Point<Part> p, double x, double y, double z) {
    EXPECT_EQ(to_string(p), to_string(Point<Part>{x, y, z}));
  };
  expect_at(read->mesh.facets[0][0], 110, 220, 330);
  expect_at(read->mesh.facets[0][1], 109, 220, 330);  // (0, 1, 0)
  expect_at(read->mesh.facets[0][2], 110, 221, 330);  // (1, 0, 0)
  expect_at(read->mesh.facets[4][2], 101, 200, 300);
  EXPECT_NEAR(volume_of(*read), 2.0 / 6.0, 1e-9);
}

TEST(ThreeMf, AMirroredPartIsTurnedOver) {
  const auto read =
      read_model(corner_object(), "<item objectid=\"1\" transform=\"-2 0 0 0 1 0 0 0 1 0 0 0\"/>");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_NEAR(volume_of(*read), 2.0 / 6.0, 1e-12);
  expect_mf_refused(
      read_model(corner_object(), "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 0 0 0 0\"/>"),
      Code::kInput, "the transform of object 1 makes it flat");
}

TEST(ThreeMf, ColoursMakeFaces) {
  std::string mesh = kMfCorner;
  mesh.replace(mesh.find("v3=\"1\""), 6, "v3=\"1\" pid=\"2\" p1=\"1\"");
  mesh.replace(mesh.find("v1=\"1\" v2=\"2\""), 13, "v1=\"1\" v2=\"2\" pid=\"9\" p1=\"0\"");
  const auto read = read_model(
      "<basematerials id=\"2\"><base name=\"steel\" displaycolor=\"#102030\"/>"
      "<base name=\"red\" displaycolor=\"#FF0000FF\"/></basematerials>"
      "<m:colorgroup id=\"9\"><m:color color=\"#00ff80\"/></m:colorgroup>"
      "<object id=\"1\" pid=\"2\" pindex=\"0\">" +
          mesh + "</object>",
      "<item objectid=\"1\"/>");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->faces.size(), 3u);
  EXPECT_EQ(read->face_of, (std::vector<std::uint32_t>{0, 1, 2, 1}));
  EXPECT_EQ(read->faces[0].name, "red");
  EXPECT_EQ(read->faces[0].colour, 0xff0000u);
  EXPECT_EQ(read->faces[1].name, "steel");
  EXPECT_EQ(read->faces[2].colour, 0x00ff80u);
  EXPECT_EQ(read->bodies[0].name, "object 1");
}

TEST(ThreeMf, SupportsAreLeftOut) {
  const auto read =
      read_model(corner_object() + "<object id=\"2\" type=\"solidsupport\">" + kMfCorner + "</object>",
                 "<item objectid=\"1\"/><item objectid=\"2\"/>");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->bodies.size(), 1u);
  ASSERT_EQ(read->mesh.warnings.size(), 1u);
  EXPECT_NE(read->mesh.warnings[0].find("1 supports are left out"), std::string::npos);
}

TEST(ThreeMf, ABeamLatticeIsLeftOutWithAWarning) {
  std::string mesh = kMfCorner;
  mesh.insert(mesh.find("</mesh>"), "<b:beamlattice/>");
  const auto read = read_model("<object id=\"1\">" + mesh + "</object>", "<item objectid=\" 1\t\"/>");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->mesh.warnings.size(), 1u);
  EXPECT_NE(read->mesh.warnings[0].find("object 1 has a beam lattice"), std::string::npos);
}

TEST(ThreeMf, EachFaultHasItsLineAndObject) {
  const std::string item = "<item objectid=\"1\"/>";
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string object = corner_object();
    object.replace(object.find(from), from.size(), to);
    return read_model(object, item);
  };
  expect_mf_refused(with("v3=\"3\"", "v3=\"4\""), Code::kInput,
                    "f.3mf: 3D/part.model:4: object 1, triangle 1: v3 is 4, and there are 4 vertices");
  expect_mf_refused(with(" v3=\"3\"", ""), Code::kInput, "v3 is missing");
  expect_mf_refused(with("z=\"1e0\"", "z=\"1mm\""), Code::kInput,
                    "object 1, vertex 3: a coordinate is no number");
  expect_mf_refused(with("z=\"1e0\"", "z=\"1e5\""), Code::kMesh,
                    "object 1 has a vertex at (0, 0, 100000) mm");
  expect_mf_refused(with("z=\"1e0\"", "z=\"1e999\""), Code::kInput, "a coordinate is no number");
  expect_mf_refused(with("z=\"1e0\"", "z=\"nan\""), Code::kMesh, "object 1 has a vertex at");
  expect_mf_refused(read_model(corner_object() + corner_object(), item), Code::kInput,
                    "object 1 is there twice");
  expect_mf_refused(read_model("<object id=\"1\"></object>", item), Code::kInput,
                    "object 1 has neither a mesh nor components");
  expect_mf_refused(read_model(corner_object(), "<item objectid=\"2\"/>"), Code::kInput,
                    "build item 0 names object 2, which is not there");
  expect_mf_refused(
      read_model("<object id=\"1\"><components><component objectid=\"1\"/></components></object>", item),
      Code::kInput, "object 1, component 0 names object 1, which is not there before it");
  expect_mf_refused(read_model(corner_object(), "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 0 0\"/>"),
                    Code::kInput, "twelve numbers");
  expect_mf_refused(
      read_model(corner_object(), "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 0 0 0 0\"/>"),
      Code::kInput, "twelve numbers");
  expect_mf_refused(read_model(corner_object(), ""), Code::kInput, "nothing of it is built");
  expect_mf_refused(read_model(corner_object(), item, "requiredextensions=\"m b\""), Code::kInput,
                    "requires the extension b (http");
  EXPECT_TRUE(read_model(corner_object(), item, "requiredextensions=\"m p\""));
  expect_mf_refused(read_model(corner_object(), "<item objectid=\"1\" p:path=\"/3D/other.model\"/>"),
                    Code::kInput, "another file of the archive");
  expect_mf_refused(parse_three_mf(three_mf_of("<model"), "f.3mf"), Code::kInput, "the XML is damaged");
  expect_mf_refused(parse_three_mf(three_mf_of("<a/>"), "f.3mf"), Code::kInput, "it has no model of 3MF");
  expect_mf_refused(parse_three_mf(three_mf_of("<!DOCTYPE m [<!ENTITY a \"b\">]><m>&a;</m>"), "f.3mf"),
                    Code::kInput, "a document type is not allowed");
  expect_mf_refused(parse_three_mf(zip_of({{"word/document.xml", "<a/>"}}), "f.3mf"), Code::kInput,
                    "this is no 3MF file");
}

TEST(ThreeMf, ComponentsThatMultiplyAreBounded) {
  std::string doubled = "<object id=\"1\">" + std::string(kMfCorner) + "</object>";
  for (int i = 2; i <= 40; ++i) {
    const std::string before = std::to_string(i - 1);
    doubled += "<object id=\"" + std::to_string(i) + "\"><components><component objectid=\"" + before +
               "\"/><component objectid=\"" + before + "\"/></components></object>";
  }
  expect_mf_refused(read_model(doubled, "<item objectid=\"40\"/>"), Code::kLimit,
                    "over the limit of 100000 components");
  std::string deep = "<object id=\"1\">" + std::string(kMfCorner) + "</object>";
  for (int i = 2; i <= 50'000; ++i)
    deep += "<object id=\"" + std::to_string(i) + "\"><components><component objectid=\"" +
            std::to_string(i - 1) + "\"/></components></object>";
  expect_mf_refused(read_model(deep, "<item objectid=\"50000\"/>"), Code::kLimit, "100 within each other");
}

/// zlib's own packing, without its wrapper.
std::string deflated(const std::string& text) {
  z_stream z{};
  EXPECT_EQ(::deflateInit2(&z, 9, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
  std::string out(::deflateBound(&z, text.size()), '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data())),
  z.avail_in = static_cast<uInt>(text.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data()), z.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(::deflate(&z, Z_FINISH), Z_STREAM_END);
  out.resize(z.total_out);
  ::deflateEnd(&z);
  return out;
}

Result<std::string> entry_of(const ZipText& entry) {
  const std::string bytes = zip_of({entry});
  const auto zip = ZipArchive::open(bytes, "f.zip");
  if (!zip) return tl::unexpected(zip.error());
  return zip->read(entry.name);
}

TEST(ZipArchive, StoredAndDeflated) {
  const std::string text(100'000, 'a');
  EXPECT_EQ(entry_of({"a", text}).value_or(""), text);
  EXPECT_EQ(entry_of({"a", text, 8, deflated(text)}).value_or(""), text);
  const std::string remark = zip_of({{"a", "text"}}, "a remark PK\x05\x06 with the mark in it");
  const auto zip = ZipArchive::open(remark, "f");
  ASSERT_TRUE(zip) << zip.error().message;
  EXPECT_EQ(zip->read("a").value_or(""), "text");
  EXPECT_FALSE(zip->read("b"));
}

void expect_entry_refused(const ZipText& entry, Code code, const std::string& piece) {
  const auto text = entry_of(entry);
  ASSERT_FALSE(text) << "accepted; expected: " << piece;
  EXPECT_EQ(text.error().code, code);
  EXPECT_NE(text.error().message.find(piece), std::string::npos) << text.error().message;
}

TEST(ZipArchive, BombsAndDamage) {
  const std::string text(100'000, 'a'), packed = deflated(text);
  // More than it says: stopped there, whatever follows.
  expect_entry_refused({"a", text, 8, packed, 0, 10}, Code::kInput, "cannot be inflated");
  expect_entry_refused({"a", text, 8, packed, 0, 100'001}, Code::kInput, "has 100000 bytes and says 100001");
  expect_entry_refused({"a", text, 8, packed, 0, 0x7fffffff}, Code::kLimit, "over the limit of 1073741824");
  expect_entry_refused({"a", text, 8, packed.substr(0, packed.size() / 2)}, Code::kInput,
                       "cannot be inflated");
  expect_entry_refused({"a", text, 12, packed}, Code::kInput, "packed by method 12");
  expect_entry_refused({"a", text, 0, {}, 1}, Code::kInput, "is encrypted");
  std::string other = text;
  other[7] = 'b';
  expect_entry_refused({"a", text, 8, deflated(other)}, Code::kInput, "wrong check sum");
}

/// The same archive as ZIP64, by hand: all sizes and places of the directory in 64 bits.
TEST(ZipArchive, SixtyFourBits) {
  const std::string text = "a text";
  std::string out = zip_of({{"a", text}});
  const std::size_t directory = out.rfind("PK\x01\x02"), end = out.rfind("PK\x05\x06");
  std::string entry = out.substr(directory, end - directory);
  out.resize(directory);
  for (const std::size_t at : {20, 24, 42}) entry.replace(at, 4, "\xff\xff\xff\xff");
  entry[30] = 4 + 24;
  put_whole(entry, 1, 2), put_whole(entry, 24, 2);
  for (const std::uint64_t value : {text.size(), text.size(), std::size_t{0}}) put_whole(entry, value, 8);
  out += entry;
  const std::size_t record = out.size();
  out += "PK\x06\x06";
  put_whole(out, 44, 8), put_whole(out, 45, 2), put_whole(out, 45, 2), put_whole(out, 0, 8);
  for (const std::uint64_t value : {std::size_t{1}, std::size_t{1}, entry.size(), directory})
    put_whole(out, value, 8);
  out += "PK\x06\x07";
  put_whole(out, 0, 4), put_whole(out, record, 8), put_whole(out, 1, 4);
  out += "PK\x05\x06";
  put_whole(out, 0xffffffffffffffff, 8), put_whole(out, 0xffffffffffffffff, 8), put_whole(out, 0, 2);
  const auto zip = ZipArchive::open(out, "f");
  ASSERT_TRUE(zip) << zip.error().message;
  EXPECT_EQ(zip->read("a").value_or(""), text);
  for (std::size_t size = 0; size < out.size(); ++size)
    EXPECT_FALSE(ZipArchive::open(std::span(out).first(size), "f")) << size;
  std::string astray = out;
  astray[out.rfind("PK\x06\x07") + 15] = '\x7f';
  EXPECT_FALSE(ZipArchive::open(astray, "f"));
}

TEST(ZipArchive, EveryTruncationIsAnError) {
  const std::string whole = three_mf_of(mf_model(corner_object(), "<item objectid=\"1\"/>"));
  ASSERT_TRUE(parse_three_mf(whole, "f"));
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(parse_three_mf(std::span(whole).first(size), "f")) << size;
}

}  // namespace
}  // namespace tiltfeed
