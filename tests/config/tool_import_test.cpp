// Tools of other programs: what is carried over, what is said of the rest, and files that are wrong.

#include "config/tool_import.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "config/new_job.h"
#include "config/yaml_tree.h"
#include "tests/texts/bad_text.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

const std::string kTable =
    "T1 P1 D0.25 Z+4.0 ;1/4 ball\n"
    "\n"
    "; nothing but a remark\n"
    "P2 Z3.5 T12 X0.1 Q2 d.5\r\n"
    "t3\tp7 D0 Z-2;\n";

const std::string kBall =
    R"({"version": 2, "name": "6 mm Ball", "shape": "ballend.fcstd", "shape-type": "Ballend",
 "parameter": {"CuttingEdgeHeight": "20.0000 mm", "Diameter": "1/4 in", "Flutes": "2", "Length": "50.0000 mm",
 "ShankDiameter": "0.8 cm", "Material": "HSS", "Units": "Metric"}, "attribute": {}})";

/// An inch tool in a metric holder, a necked one without holder, a taper, and what is no cutter here.
const std::string kFusion = R"({"version": 36, "data": [
 {"BMC": "carbide", "description": "1/2\" bull \u00b5", "guid": "a", "type": "bull nose end mill", "unit": "inches",
  "product-id": "B-05", "vendor": "none",
  "geometry": {"DC": 0.5, "RE": 0.0625, "NOF": 4, "LCF": 1, "LB": 2, "OAL": 3, "SFDM": 0.5, "HAND": true},
  "holder": {"unit": "millimeters", "gaugeLength": 60, "description": "ER32",
   "segments": [{"height": 20, "lower-diameter": 40, "upper-diameter": 50}, {"height": 0, "lower-diameter": 50,
    "upper-diameter": 63}, {"height": 40, "lower-diameter": 63, "upper-diameter": 63}]},
  "post-process": {"number": 4, "diameter-offset": 4, "length-offset": 4, "live": true},
  "start-values": {"presets": [
   {"name": "P", "n": 5000, "v_f": 40, "v_f_plunge": 10, "f_z": 0.002, "v_c": 654, "material": {"category": "steel"}},
   {"name": "Q", "n": 6000, "v_f": 50, "v_f_plunge": 12, "stepover": 0.1, "material": {"category": "steel"}}]}},
 {"description": "neck", "type": "ball end mill", "unit": "millimeters", "geometry": {"DC": 4, "NOF": 2, "LCF": 6,
  "LB": 40, "SFDM": 6, "shoulder-length": 20, "shoulder-diameter": 3.8, "assemblyGaugeLength": 110},
  "shaft": {"segments": [{"height": 20, "lower-diameter": 3.8, "upper-diameter": 3.8},
   {"height": 20, "lower-diameter": 6, "upper-diameter": 8}]},
  "post-process": {"number": 4, "length-offset": 14}},
 {"description": "neck", "type": "tapered mill", "tapered-type": "tapered_ball", "unit": "millimeters",
  "geometry": {"DC": 2, "RE": 1, "TA": 3, "LCF": 30, "LB": 30, "SFDM": 6, "assemblyGaugeLength": 30}},
 {"description": "D8", "type": "drill", "unit": "millimeters", "geometry": {"DC": 8, "SIG": 118}},
 {"description": "wide", "type": "flat end mill", "unit": "millimeters", "geometry": {"DC": 9000, "LB": 50}}]})";

bool noted(const ToolImport& import, const std::string& what) {
  return std::any_of(import.notes.begin(), import.notes.end(),
                     [&](const std::string& note) { return note.find(what) != note.npos; });
}

class Imports : public testing::Test {
 protected:
  Result<ToolImport> from(const std::string& name, const std::string& text,
                          ImportOptions options = {}) const {
    return import_tools(folder_.write(name, text), options);
  }
  /// What the reader of libraries makes of the text that is written.
  ToolLibrary read_back(const ToolImport& import) const {
    const std::string text = tool_library_text(import.tools, "made by a test\nof two lines");
    const auto library = parse_tool_library(text, "t.yaml");
    EXPECT_TRUE(library.has_value()) << library.error().message << "\n" << text;
    return library.value_or(ToolLibrary{});
  }
  const Folder folder_{"tool_import"};
};

TEST_F(Imports, ReadsAToolTable) {
  EXPECT_EQ(from("t.tbl", kTable).error().code, Code::kUsage);  // of what unit?
  const auto table = from("t.tbl", kTable, {25.4});
  ASSERT_TRUE(table.has_value()) << table.error().message;
  const ToolLibrary library = read_back(*table);
  ASSERT_EQ(library.tools.size(), 3u);
  EXPECT_EQ(library.tools[0].id, "T1");
  EXPECT_EQ(library.tools[0].name, "1/4 ball");
  EXPECT_EQ(table->tools[0].diameter, 6.35);
  EXPECT_EQ(table->tools[0].length, 101.6);
  EXPECT_EQ(library.tools[0].lacks, (std::vector<std::string>{"type", "shank_length_mm"}));
  EXPECT_EQ(library.tools[1].number, 12);
  EXPECT_EQ(table->tools[1].diameter, 12.7);
  EXPECT_TRUE(noted(*table, "T12: not carried over: P2 X0.1 Q2"));
  EXPECT_TRUE(noted(*table, "T3: not carried over: p7 Z-2 (a length from the gauge line"));
  EXPECT_EQ(table->tools[2].diameter, 0.0);
}

TEST_F(Imports, SaysWhereAToolTableIsWrong) {
  for (const auto& [text, what] : std::vector<std::pair<std::string, std::string>>{
           {"T1 P1 D0.25\nT2 D1,5\n", ":2:4: 'D1,5': expected a number behind D"},
           {"T1 K5\n", ":1:4: 'K5' is no word of a tool table"},
           {"P1 D5\n", ":1:1: no tool number"},
           {"T1.5\n", ":1:1: 'T1.5': expected a whole number"},
           {"T1 Dnan\n", ":1:4: 'Dnan': expected a number"},
           {"; nothing\n", ": has no tool"},
           {"POC FMS LEN DIAM\n", ":1:1: 'POC': expected a number behind P"}}) {
    const auto table = from("t.tbl", text, {1.0});
    ASSERT_FALSE(table.has_value()) << text;
    EXPECT_NE(table.error().message.find("t.tbl" + what), std::string::npos) << table.error().message;
  }
}

TEST_F(Imports, ReadsAToolBitAndALibraryOfThem) {
  const auto bit = from("b.fctb", kBall);
  ASSERT_TRUE(bit.has_value()) << bit.error().message;
  ASSERT_EQ(bit->tools.size(), 1u);
  EXPECT_EQ(bit->tools[0].type, CutterType::kBall);
  EXPECT_EQ(bit->tools[0].diameter, 6.35);
  EXPECT_EQ(bit->tools[0].cutting_length, 20.0);
  EXPECT_EQ(bit->tools[0].shank_diameter, 8.0);
  EXPECT_EQ(bit->tools[0].flutes, 2);
  EXPECT_EQ(bit->tools[0].id, "6-mm-Ball");
  EXPECT_TRUE(noted(*bit, "not carried over: parameter.Length, parameter.Material"));
  EXPECT_EQ(read_back(*bit).tools[0].lacks, (std::vector<std::string>{"length_mm", "shank_length_mm"}));

  const std::string bull = replaced(replaced(kBall, "ballend", "bullnose"), "\"Flutes\"",
                                    "\"FlatRadius\": \"2.175 mm\", \"Flutes\"");
  std::filesystem::create_directory(folder_.path + "/Bit");
  folder_.write("Bit/bull.fctb", bull);
  folder_.write("Bit/drill.fctb", replaced(replaced(kBall, "ballend", "drill"), "Ballend", "Drill"));
  std::filesystem::create_directory(folder_.path + "/Library");
  const auto library =
      from("Library/l.fctl",
           R"({"version": 1, "tools": [{"nr": 5, "path": "bull.fctb"}, {"nr": 6, "path": "drill.fctb"}]})");
  ASSERT_TRUE(library.has_value()) << library.error().message;
  ASSERT_EQ(library->tools.size(), 1u);
  EXPECT_EQ(library->tools[0].number, 5);
  EXPECT_NEAR(library->tools[0].corner_radius, 1.0, 1e-12);
  EXPECT_TRUE(noted(*library, "left out: 'drill'"));
  const auto gone = from("Library/m.fctl", R"({"tools": [{"nr": 5, "path": "none.fctb"}]})");
  ASSERT_FALSE(gone.has_value());
  EXPECT_NE(gone.error().message.find("m.fctl: tools[1]: there is no 'none.fctb'"), std::string::npos);
  const auto unit = from("u.fctb", replaced(kBall, "1/4 in", "6"));
  ASSERT_FALSE(unit.has_value());
  EXPECT_NE(unit.error().message.find("u.fctb: parameter.Diameter: expected a length with its unit"),
            std::string::npos);
}

TEST_F(Imports, ReadsALibraryOfFusion) {
  const auto fusion = from("f.json", kFusion);
  ASSERT_TRUE(fusion.has_value()) << fusion.error().message;
  const ToolLibrary library = read_back(*fusion);
  ASSERT_EQ(library.tools.size(), 3u);
  const LibraryTool& bull = library.tools[0];
  EXPECT_TRUE(bull.lacks.empty());
  EXPECT_EQ(bull.id, "1-2-bull");
  EXPECT_EQ(bull.name, "1/2\" bull \xc2\xb5");
  EXPECT_EQ(bull.product, "B-05");
  EXPECT_EQ(bull.number, 4);
  EXPECT_EQ(bull.flutes, 4);
  EXPECT_EQ(
      cutter_text(bull.cutter),
      "type: bull_nose, diameter_mm: 12.7, corner_radius_mm: 1.5875, length_mm: 110.8, cutting_length_mm: "
      "25.4, "
      "shank_diameter_mm: 12.7, shank_length_mm: 50.8, holder: [{diameter_mm: 40, upper_diameter_mm: 50, "
      "length_mm: 20}, {diameter_mm: 63, upper_diameter_mm: 63, length_mm: 40}]");
  ASSERT_EQ(bull.data.size(), 2u);
  EXPECT_EQ(bull.data[1].material, "steel (2)");
  EXPECT_EQ(bull.data[0].spindle_rpm, 5000.0);
  EXPECT_EQ(bull.data[0].cut_feed, 1016.0);
  EXPECT_EQ(bull.data[0].plunge_feed, 254.0);
  EXPECT_EQ(library.tools[1].cutter.shank_diameter, 8.0);
  EXPECT_EQ(library.tools[1].cutter.length, 110.0);
  EXPECT_EQ(library.tools[2].id, "neck-2");
  EXPECT_EQ(library.tools[2].lacks, (std::vector<std::string>{"taper_deg", "length_mm"}));
  EXPECT_TRUE(noted(*fusion, "'neck': the shaft of 2 steps is taken as one of 8 mm"));
  EXPECT_TRUE(noted(*fusion, "'neck': post-process.length-offset is another number"));
  EXPECT_FALSE(noted(*fusion, "diameter-offset")) << "it is not stated";
  EXPECT_TRUE(noted(*fusion, "TA 3 may be the half or the whole angle"));
  EXPECT_TRUE(noted(*fusion, "'D8': left out: 'drill' is no form"));
  EXPECT_TRUE(noted(*fusion, "wide: left out: diameter_mm: '9000' is out of range"));
  EXPECT_TRUE(noted(*fusion, "BMC (1)"));
  EXPECT_TRUE(noted(*fusion, "start-values.presets.stepover (1)"));
}

TEST_F(Imports, SaysWhereOtherFilesAreWrong) {
  const auto says = [&](const std::string& name, const std::string& text, const std::string& what) {
    const auto import = from(name, text);
    ASSERT_FALSE(import.has_value()) << text;
    EXPECT_NE(import.error().message.find(what), std::string::npos) << import.error().message;
  };
  says("f.json", "{\"data\": [", "f.json: no JSON at line 1");
  says("f.json", "{\"data\": 3}", "expected a list at \"data\"");
  says("f.json", replaced(kFusion, "inches", "furlongs"),
       "data[1]: unit: expected millimeters or inches, found 'furlongs'");
  says("f.json", replaced(kFusion, "\"geometry\": {\"DC\": 4,", "\"geom\": {\"DC\": 4,"),
       "data[2]: geometry: missing");
  says("f.json", std::string(100'000, '['), "no JSON");
  says("f.json", "{\"data\": " + std::string(200, '[') + std::string(200, ']') + "}", "over 64 levels deep");
  says("b.fctb", "[]", "expected a map at \"parameter\"");
  says("l.fctl", "{}", "expected a list of at most");
  says("x.tools", "PK", "export the library as JSON");
  says("x.csv", "", "expected .tbl");
  EXPECT_FALSE(import_tools(folder_.path + "/none.json", {}).has_value());
  EXPECT_EQ(from("f.json", kFusion, {1.0}).error().code, Code::kUsage);
}

/// Cut off, and with bytes changed: an error or tools that a library takes, never anything else.
TEST_F(Imports, DamagedFilesNeverMakeALibraryThatIsWrong) {
  std::mt19937 dice(7);
  const auto any = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(dice);
  };
  const std::string bytes = "0123456789.,-+eE\"{}[]: \nTDZ\xff\x80\x01";
  int taken = 0;
  for (const auto& [name, text] : {std::pair{"t.tbl", kTable}, {"b.fctb", kBall}, {"f.json", kFusion}})
    for (int i = 0; i < 60; ++i) {
      std::string damaged = text;
      if (i % 3 == 0) damaged.resize(any(text.size()));
      for (std::size_t k = 0; k < 1 + any(3) && !damaged.empty(); ++k)
        damaged[any(damaged.size())] = bytes[any(bytes.size())];
      const bool table = std::string(name) == "t.tbl";
      const auto import = from(name, damaged, table ? ImportOptions{1.0} : ImportOptions{});
      if (!import) continue;
      EXPECT_EQ(import->tools.empty() ? 0 : read_back(*import).tools.size(), import->tools.size()) << damaged;
      ++taken;
    }
  EXPECT_GT(taken, 10);
}

}  // namespace
}  // namespace tiltfeed
