// What tiltfeed-cad hands over, there and back; every damaged byte; bodies and faces by name and colour; the
// formats by their first bytes.

#include "pathgen/part_file/cad_stream.h"

#include <gtest/gtest.h>

#include <limits>

#include "pathgen/part_file/file_kind.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

/// Two bodies of one face each, and a third with two: a triangle a face.
struct Sample {
  PartModel model;
  std::vector<FaceFacets> facets;
};
Sample sample() {
  Sample s;
  s.model.format = "STEP", s.model.unit = "inch", s.model.unit_mm = 25.4, s.model.allowed = 0.01;
  s.model.mesh.warnings = {"a warning"};
  s.model.bodies = {{"lid", "lid", true}, {"box", "housing", false}, {"pin", "housing", true}};
  const std::uint32_t body_of[] = {0, 1, 2, 2};
  for (std::uint32_t i = 0; i < 4; ++i) {
    PartFace face;
    face.body = body_of[i], face.surface = "plane",
    face.entity = "#" + std::to_string(i + 1) + " ADVANCED_FACE";
    face.deviation = 0.001 * (i + 1);
    if (i == 1) face.name = "floor";
    if (i >= 2) face.colour = 0x00ff80u + i - 2;
    s.model.faces.push_back(face);
    const double z = i;
    s.facets.push_back({{{0, 0, z}, {1, 0, z}, {0, 1, z}}, {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}, {{0, 1, 2}}});
  }
  return s;
}

Result<PartModel> there_and_back(const Sample& s) {
  const std::string bytes = cad_stream(s.model, s.facets);
  return read_cad_stream(bytes, "f.step");
}

TEST(CadStream, ThereAndBack) {
  const Sample s = sample();
  const auto read = there_and_back(s);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->format, "STEP");
  EXPECT_EQ(read->unit, "inch");
  EXPECT_EQ(read->unit_mm, 25.4);
  EXPECT_EQ(read->allowed, 0.01);
  EXPECT_EQ(read->deviation, 0.004);
  EXPECT_EQ(read->mesh.warnings, s.model.mesh.warnings);
  ASSERT_EQ(read->bodies.size(), 3u);
  EXPECT_EQ(read->bodies[1].product, "housing");
  EXPECT_FALSE(read->bodies[1].closed);
  EXPECT_EQ(read->face_of, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(read->faces[i].colour, s.model.faces[i].colour);
    EXPECT_EQ(read->faces[i].entity, s.model.faces[i].entity);
    EXPECT_EQ(read->mesh.facets[i][1].z, static_cast<double>(i));
  }
}

TEST(CadStream, EveryTruncationAndEveryChangedByteIsAnError) {
  const Sample s = sample();
  const std::string bytes = cad_stream(s.model, s.facets);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(read_cad_stream(std::span(bytes).first(size), "f")) << size;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    EXPECT_FALSE(read_cad_stream(damaged, "f")) << at;
  }
  EXPECT_FALSE(read_cad_stream(bytes + "x", "f"));
}

void expect_in(const Result<PartModel>& read, const std::string& piece) {
  ASSERT_FALSE(read) << "accepted; expected: " << piece;
  EXPECT_NE(read.error().message.find(piece), std::string::npos) << read.error().message;
}

TEST(CadStream, WhatIsWrittenWrongIsRefused) {
  Sample s = sample();
  s.facets[2].corners[1].x = std::numeric_limits<double>::quiet_NaN();
  expect_in(there_and_back(s), "#3 ADVANCED_FACE has a corner at");
  s = sample(), s.facets[1].corners[0].y = 10'001.0;
  expect_in(there_and_back(s), "beyond the limit of 10000 mm");
  s = sample(), s.facets[0].facets[0][2] = 3;
  expect_in(there_and_back(s), "a corner that is not there");
  s = sample(), s.model.faces[3].body = 3;
  expect_in(there_and_back(s), "a body that is not there");
  s = sample(), s.facets[0].normals.pop_back();
  expect_in(there_and_back(s), "2 normals for 3 corners");
  s = sample(), std::swap(s.facets[1].facets[0][1], s.facets[1].facets[0][2]);
  const auto turned = there_and_back(s);
  ASSERT_TRUE(turned);
  ASSERT_EQ(turned->mesh.warnings.size(), 2u);
  EXPECT_NE(turned->mesh.warnings[1].find("#2 ADVANCED_FACE are turned against"), std::string::npos);
}

TEST(PartModel, BodiesByNameOrProduct) {
  const auto all = there_and_back(sample());
  ASSERT_TRUE(all);
  PartModel one = *all;
  ASSERT_TRUE(keep_bodies(one, {"pin"}, "f"));
  ASSERT_EQ(one.bodies.size(), 1u);
  EXPECT_EQ(one.faces.size(), 2u);
  EXPECT_EQ(one.face_of, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(one.faces[1].body, 0u);
  EXPECT_EQ(one.mesh.facets[0][0].z, 2.0);
  PartModel housing = *all;
  ASSERT_TRUE(keep_bodies(housing, {"housing"}, "f"));
  EXPECT_EQ(housing.bodies.size(), 2u);
  EXPECT_EQ(housing.mesh.facets.size(), 3u);
  PartModel lid = *all;
  ASSERT_TRUE(keep_bodies(lid, {"lid"}, "f"));
  EXPECT_EQ(lid.deviation, 0.001);
  PartModel none = *all;
  const auto refused = keep_bodies(none, {"lib"}, "f.step");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "f.step: no body has the name \"lib\"; there are \"lid\", \"box\", \"pin\"");
  PartModel mesh;
  EXPECT_TRUE(keep_bodies(mesh, {}, "f.stl"));
  EXPECT_FALSE(keep_bodies(mesh, {"lid"}, "f.stl"));
}

TEST(PartModel, FacesByNameOrColour) {
  const auto all = there_and_back(sample());
  ASSERT_TRUE(all);
  EXPECT_EQ(*faces_named(*all, {"floor", "#00ff81"}, "f"), (std::vector<bool>{false, true, false, true}));
  const auto refused = faces_named(*all, {"#ff0000"}, "f.step");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "f.step: no face has the name or colour \"#ff0000\"; names: \"floor\"; colours: \"#00ff80\", "
            "\"#00ff81\"");
  EXPECT_FALSE(faces_named(PartModel{}, {"floor"}, "f.stl"));
}

TEST(PartModel, NotesSayUnitAndDeviation) {
  const auto all = there_and_back(sample());
  ASSERT_TRUE(all);
  EXPECT_EQ(notes_on(*all),
            (std::vector<std::string>{
                "STEP file in inch, taken as 25.4 mm each: 3 bodies, \"lid\", \"box\", \"pin\"; 4 faces",
                "facets leave the surfaces by 0.004 mm at most (measured), allowed 0.01 mm"}));
  EXPECT_TRUE(notes_on(PartModel{}).empty());
}

TEST(FileKind, ByContent) {
  const auto format = [](const std::string& text) { return format_of(text); };
  EXPECT_EQ(format("ISO-10303-21;\nHEADER;"), PartFormat::kStep);
  EXPECT_EQ(format("\xef\xbb\xbf \r\nISO-10303-21;"), PartFormat::kStep);
  EXPECT_EQ(format("PK\x03\x04rest"), PartFormat::kThreeMf);
  const std::string iges = std::string(72, ' ') + "S      1\n";
  EXPECT_EQ(format(iges), PartFormat::kIges);
  EXPECT_EQ(format(std::string(72, ' ') + "S0000001\r\n"), PartFormat::kIges);
  EXPECT_EQ(format(iges.substr(0, 79)), PartFormat::kMesh);
  EXPECT_EQ(format("solid ISO-10303-21"), PartFormat::kMesh);
  EXPECT_EQ(format(""), PartFormat::kMesh);
  EXPECT_EQ(format_of_file("/no/such/file"), PartFormat::kMesh);
}

}  // namespace
}  // namespace tiltfeed
