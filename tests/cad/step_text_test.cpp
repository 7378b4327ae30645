// What is wrong with the text of a STEP or IGES file, each by hand.

#include <gtest/gtest.h>

#include "cad/text/iges_text.h"
#include "cad/text/step_text.h"

namespace tiltfeed::cad {
namespace {

std::string step_of(const std::string& data) {
  return "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('CONFIG_CONTROL_DESIGN {1 0}'));\nENDSEC;\nDATA;\n" + data +
         "ENDSEC;\nEND-ISO-10303-21;\n";
}

void expect_step_refused(const std::string& text, const std::string& piece) {
  const auto found = check_step_text(text, "f.step");
  ASSERT_FALSE(found) << "accepted; expected: " << piece;
  EXPECT_NE(found.error().message.find(piece), std::string::npos)
      << found.error().message << "\nlacks: " << piece;
  EXPECT_TRUE(found.error().message.starts_with("f.step: ")) << found.error().message;
}

TEST(StepText, EntitiesTypesAndSchema) {
  const auto found =
      check_step_text(step_of("#10 = CARTESIAN_POINT('it''s; #99 /* no remark */',(0.,-1.5E-3,+2.));\n"
                              "/* #98 is none; */ #2=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n"
                              "#7=VERTEX_POINT ( '' , #10 ) ;\n"),
                      "f.step");
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->types.size(), 3u);
  EXPECT_EQ(found->name(2), "#2 LENGTH_UNIT");
  EXPECT_EQ(found->name(7), "#7 VERTEX_POINT");
  EXPECT_EQ(found->name(10), "#10 CARTESIAN_POINT");
  EXPECT_EQ(found->name(11), "#11");
  EXPECT_EQ(found->schema, "CONFIG_CONTROL_DESIGN");
}

TEST(StepText, EachFaultHasItsEntity) {
  expect_step_refused("solid\n", "does not begin with ISO-10303-21");
  expect_step_refused(step_of(""), "no entities");
  expect_step_refused(step_of("#1=VERTEX_POINT('',#2);\n"),
                      "#1 VERTEX_POINT refers to #2, which is not there");
  expect_step_refused(step_of("#1=DIRECTION('',(0.,0.,1.));\n#1=DIRECTION('',(0.,1.,0.));\n"),
                      "#1 is there twice");
  expect_step_refused(step_of("#3=ORIENTED_EDGE('',*,*,#3,.T.);\n"), "#3 ORIENTED_EDGE refers to itself");
  expect_step_refused(step_of("#1=A(#2);\n#2=B(#3);\n#3=C(#1);\n#4=D(#1);\n"), "refers to itself");
  expect_step_refused(step_of("#1=CIRCLE('',1.0E999);\n"), "#1 CIRCLE: 1.0E999 is out of range, at line 6");
  expect_step_refused(step_of("#4=CARTESIAN_POINT('',(0.,1.0E12,0.));\n"),
                      "#4 CARTESIAN_POINT: 1.0E12 is out of range");
  expect_step_refused(step_of("#4 CARTESIAN_POINT('',(0.,1.,0.));\n"), "#4 has no '='");
  // Too small is as good as zero, and a parameter may be as large as it likes.
  EXPECT_TRUE(check_step_text(step_of("#1=LINE('',1.0E-999,2.0E100);\n"), "f.step"));
}

TEST(StepText, EveryTruncationIsAnError) {
  const std::string whole = step_of("#1=CARTESIAN_POINT('a',(0.,1.,2.));\n#2=VERTEX_POINT('',#1);\n");
  ASSERT_TRUE(check_step_text(whole, "f.step"));
  const std::size_t end = whole.rfind("END-ISO-10303-21") + 16;
  for (std::size_t size = 0; size < end; ++size)
    EXPECT_FALSE(check_step_text(std::string_view(whole).substr(0, size), "f.step")) << size;
  expect_step_refused(whole.substr(0, whole.find("1.,2.")), "cut short in #1 CARTESIAN_POINT, at line 6");
}

TEST(StepText, LongChainsAreNoCircle) {
  std::string data;
  constexpr int kLinks = 100'000;
  for (int i = 1; i < kLinks; ++i)
    data += "#" + std::to_string(i) + "=A(#" + std::to_string(i + 1) + ",#" + std::to_string(kLinks) + ");\n";
  data += "#" + std::to_string(kLinks) + "=B();\n";
  EXPECT_TRUE(check_step_text(step_of(data), "f.step"));
}

std::string iges_line(const std::string& text, char section, int number) {
  std::string line = text;
  line.resize(72, ' ');
  std::string count = std::to_string(number);
  return line + section + std::string(7 - count.size(), ' ') + count + "\n";
}

std::string iges_of(const std::string& lines_of_parameters = "       1",
                    const std::string& last = "S      1G      1D      2P      1") {
  return iges_line("made by hand", 'S', 1) + iges_line("1H,,1H;;", 'G', 1) +
         iges_line("     116       1       0       0", 'D', 1) +
         iges_line("     116       0       0" + lines_of_parameters, 'D', 2) +
         iges_line("116,0.,0.,0.;                                                  1", 'P', 1) +
         iges_line(last, 'T', 1);
}

void expect_iges_refused(const std::string& text, const std::string& piece) {
  const auto found = check_iges_text(text, "f.igs");
  ASSERT_FALSE(found) << "accepted; expected: " << piece;
  EXPECT_NE(found.error().message.find(piece), std::string::npos)
      << found.error().message << "\nlacks: " << piece;
}

TEST(IgesText, CountsAndSections) {
  const std::string good = iges_of();
  ASSERT_TRUE(check_iges_text(good, "f.igs")) << check_iges_text(good, "f.igs").error().message;
  std::string crlf;
  for (const char c : good) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  EXPECT_TRUE(check_iges_text(crlf, "f.igs"));
  for (std::size_t size = 0; size + 1 < good.size(); ++size)
    EXPECT_FALSE(check_iges_text(std::string_view(good).substr(0, size), "f.igs")) << size;
  expect_iges_refused(good.substr(0, 4 * 81), "cut short: it has no line of section T");
  expect_iges_refused(good.substr(0, 81) + good.substr(2 * 81), "section G has 0 lines");
  expect_iges_refused(good.substr(0, 2 * 81) + good.substr(3 * 81), "is not 1: a line is missing");
  expect_iges_refused(good.substr(81) + good.substr(0, 81), "f.igs:");
  expect_iges_refused(iges_of("       2"),
                      "D1 (type 116) has no parameters: it names lines P1 and 2 in all, of 1");
  expect_iges_refused(iges_of("       1", "S      1G      1D      2P      2"),
                      "'P      2', and section P has 1 lines");
}

}  // namespace
}  // namespace tiltfeed::cad
