// Tool libraries: read, referred to by jobs, held against the magazine.

#include "config/tool_library.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>
#include <sstream>

#include "config/job.h"
#include "config/new_job.h"
#include "tests/texts/bad_text.h"
#include "tests/texts/folder.h"
#include "tests/texts/job_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

const std::string kTools =
    "tools:\n"                                                                           // 1
    "  - id: ball-6\n"                                                                   // 2
    "    number: 3\n"                                                                    // 3
    "    type: ball\n"                                                                   // 4
    "    diameter_mm: 6\n"                                                               // 5
    "    flutes: 2\n"                                                                    // 6
    "    length_mm: 100\n"                                                               // 7
    "    shank_length_mm: 30\n"                                                          // 8
    "    cutting_data:\n"                                                                // 9
    "      - {material: steel, cutting_speed_m_per_min: 150, feed_per_tooth_mm: 0.05, "  // 10
    "plunge_mm_per_min: 250}\n"                                                          //
    "      - {material: wood, spindle_rpm: 18000, cut_mm_per_min: 5000}\n"               // 11
    "  - {id: T9, diameter_mm: 4, length_mm: 80}\n";                                     // 12

const std::string kCutter = "cutter: {type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}";
const std::string kFeeds = "feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300, spindle_rpm: 9000}\n";

/// A folder with tools.yaml, machine.yaml and job.yaml.
class ToolJobs : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const { folder_.write(name, text); }
  std::string file(const std::string& name) const { return folder_.path + "/" + name; }
  /// The good job with this section cutter on a machine with this magazine.
  Result<Job> job(const std::string& cutter, const std::string& magazine = "", const std::string& from = "",
                  const std::string& to = "") const {
    write("tools.yaml", kTools);
    write("machine.yaml", file_text(SOURCE_DIR "/config/machines/generic-ac.yaml") + magazine);
    std::string text = replaced(kGoodJob, kCutter, "cutter: " + cutter);
    text = replaced(text, "../machines/generic-ac.yaml", "machine.yaml");
    write("job.yaml", from.empty() ? text : replaced(text, from, to));
    return load_job(file("job.yaml"));
  }
  std::string refusal(const Result<Job>& job) const {
    EXPECT_FALSE(job.has_value());
    if (job) return "";
    EXPECT_EQ(job.error().message.rfind(folder_.path, 0), 0u) << job.error().message;
    return job.error().message.substr(folder_.path.size() + 1);
  }

  const Folder folder_{"tool_library"};
};

TEST_F(ToolJobs, AToolOfALibraryMakesTheJobThatItsFormMakes) {
  const auto typed = job("{type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}");
  const auto named = job("{library: tools.yaml, id: ball-6}");
  ASSERT_TRUE(typed.has_value() && named.has_value()) << named.error().message;
  EXPECT_EQ(cutter_text(named->plan.cutter), cutter_text(typed->plan.cutter));
  EXPECT_EQ(named->setup.tool_length, typed->setup.tool_length);
  EXPECT_EQ(named->spindle_rpm, 9000.0);
  EXPECT_EQ(named->program.tool, 3);
  EXPECT_EQ(typed->program.tool, 0);
  EXPECT_EQ(named->tools_path, file("tools.yaml"));
  EXPECT_EQ(describe(*typed).find("cutter.library"), std::string::npos);
  EXPECT_NE(describe(*named).find("cutter.id: ball-6\n"), std::string::npos);
}

TEST_F(ToolJobs, TakesFeedsOfTheMaterialWhereTheJobSaysNone) {
  const auto steel = job("{library: tools.yaml, id: ball-6, material: steel}", "", kFeeds, "");
  ASSERT_TRUE(steel.has_value()) << steel.error().message;
  const double turns = std::floor(150'000.0 / (6.0 * std::numbers::pi));
  EXPECT_EQ(steel->spindle_rpm, turns);
  EXPECT_NEAR(steel->plan.cut_feed.mm_per_min(), 2 * 0.05 * turns, 1e-9);
  EXPECT_EQ(steel->plan.plunge_feed.mm_per_min(), 250.0);
  const auto own = job("{library: tools.yaml, id: ball-6, material: wood}", "", kFeeds,
                       "feeds: {cut_mm_per_min: 4000, plunge_mm_per_min: 100}\n");
  ASSERT_TRUE(own.has_value()) << own.error().message;
  EXPECT_EQ(own->plan.cut_feed.mm_per_min(), 4000.0);
  EXPECT_EQ(own->spindle_rpm, 18000.0);
  // wood states no plunge feed.
  EXPECT_NE(refusal(job("{library: tools.yaml, id: ball-6, material: wood}", "", kFeeds, ""))
                .find("plunge_mm_per_min"),
            std::string::npos);
}

TEST_F(ToolJobs, SaysWhatIsWrongWithAReference) {
  const std::string place = "job.yaml:2:";
  const auto says = [&](const std::string& cutter, const std::string& what) {
    const std::string message = refusal(job(cutter));
    EXPECT_EQ(message.rfind(place, 0), 0u) << message;
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  says("{library: tools.yaml, id: ball-7}",
       "'ball-7' is no tool of " + file("tools.yaml") + "; nearest: 'ball-6'");
  says("{library: tools.yaml, id: T9}", "lacks type, shank_length_mm; measure");
  says("{library: tools.yaml, id: T9}", "tools.yaml:12:5");
  says("{library: tools.yaml}", "missing key 'cutter.id'");
  says("{library: none.yaml, id: ball-6}", "none.yaml");
  says("{library: tools.yaml, id: ball-6, diameter_mm: 6}", "cutter.diameter_mm: not used");
  says("{library: tools.yaml, id: ball-6, material: stel}", "nearest: 'steel'");
  says("{material: steel, type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}",
       "cutter.material: not used without library");
}

TEST_F(ToolJobs, ATooLNotInTheMagazineIsNamedBeforePlanning) {
  const std::string tools = "\nmagazine:\n  - {number: 5, id: ball-6}\n  - {number: 7, id: flat-10}\n";
  const std::string named = "{library: tools.yaml, id: ball-6}";
  const std::string typed = "type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}";
  EXPECT_EQ(job(named, tools)->program.tool, 5);
  EXPECT_EQ(job("{id: ball-6, " + typed, tools)->program.tool, 5);
  EXPECT_EQ(job("{" + typed, tools)->program.tool, 0);
  const auto number = [&](const std::string& cutter, const std::string& tool) {
    return job(cutter, tools, kFeeds, kFeeds + "program: {tool: " + tool + "}\n");
  };
  EXPECT_EQ(number(named, "5")->program.tool, 5);
  EXPECT_EQ(number(named, "0")->program.tool, 0);  // it is in the spindle
  EXPECT_EQ(number("{" + typed, "7")->program.tool, 7);
  EXPECT_NE(
      refusal(number(named, "7")).find("T7 is not 'ball-6' in the machine's magazine, where that is T5"),
      std::string::npos);
  EXPECT_NE(refusal(number("{" + typed, "8")).find("job.yaml:16:17: program.tool: T8 is not in"),
            std::string::npos);
  const std::string missing = refusal(job("{id: ball-8, " + typed, tools));
  EXPECT_EQ(missing.rfind("job.yaml:2:14: cutter.id: 'ball-8' is not in the machine's magazine", 0), 0u)
      << missing;
  EXPECT_NE(missing.find("T5 ball-6, T7 flat-10"), std::string::npos) << missing;
  EXPECT_NE(missing.find(file("machine.yaml")), std::string::npos) << missing;
  const auto twice = job("{" + typed, "\nmagazine: [{number: 5, id: a}, {number: 5, id: b}]\n");
  ASSERT_FALSE(twice.has_value());
  EXPECT_NE(twice.error().message.find("magazine[2].number: 5 is that of 'a' too"), std::string::npos)
      << twice.error().message;
}

TEST_F(ToolJobs, ItsToolWrittenOutIsTheSameJob) {
  for (const std::string cutter :
       {"{library: tools.yaml, id: ball-6}", "{library: tools.yaml, id: ball-6, material: steel}",
        "\n  library: tools.yaml   # the shop's\n  id: ball-6\n"}) {
    const auto named = job(cutter, "\nmagazine: [{number: 5, id: ball-6}]\n");
    ASSERT_TRUE(named.has_value()) << named.error().message;
    const std::string text = *read_config_text(file("job.yaml"));
    const auto whole = with_tool_written_out(text, file("job.yaml"), {});
    ASSERT_TRUE(whole.has_value()) << whole.error().message;
    // Somewhere else, where there is no library.
    const auto again = load_job_with(
        [&] {
          std::filesystem::create_directory(file("else"));
          write("else/job.yaml", *whole);
          return file("else/job.yaml");
        }(),
        {named->stl_path, named->machine.path});
    ASSERT_TRUE(again.has_value()) << again.error().message << "\n" << *whole;
    std::string wanted = describe(*named), found = describe(*again);
    for (const char* key : {"cutter.library: ", "cutter.material: "})
      if (const std::size_t at = wanted.find(key); at != wanted.npos)
        wanted.erase(at, wanted.find('\n', at) + 1 - at);
    EXPECT_EQ(found.substr(found.find('\n')), wanted.substr(wanted.find('\n')));
  }
  const std::string plain = replaced(kGoodJob, kCutter, kCutter + "  # as it is");
  EXPECT_EQ(with_tool_written_out(plain, kJobPath, {}).value(), plain);
}

TEST(ToolLibrary, TheExampleIsRightAndSaysEachKey) {
  const std::string path = SOURCE_DIR "/config/tools/example.yaml";
  const auto library = load_tool_library(path);
  ASSERT_TRUE(library.has_value()) << library.error().message;
  ASSERT_EQ(library->tools.size(), 4u);
  for (const LibraryTool& tool : library->tools) EXPECT_TRUE(tool.lacks.empty()) << tool.id;
  EXPECT_EQ(library->tools[3].cutter.type, CutterType::kTaperBall);
  const std::string text = *read_config_text(path);
  // The reader's own list of keys, as it says it of one that it does not know.
  const auto unknown = parse_tool_library("tools: [{ide: x}]", "t.yaml");
  ASSERT_FALSE(unknown.has_value());
  const std::string& said = unknown.error().message;
  std::istringstream keys(said.substr(said.find("(known here: ") + 13));
  int count = 0;
  for (std::string key; std::getline(keys, key, ',') && key.find('\n') == key.npos; ++count) {
    key.erase(0, key.find_first_not_of(' '));
    if (const std::size_t end = key.find(')'); end != key.npos) key.resize(end);
    EXPECT_NE(text.find(key + ":"), std::string::npos) << key;
  }
  EXPECT_GE(count, 15);
}

TEST(ToolLibrary, SaysWhereAFileIsWrong) {
  const auto says = [](const std::string& from, const std::string& to, const std::string& what) {
    const auto library = parse_tool_library(replaced(kTools, from, to), "t.yaml");
    ASSERT_FALSE(library.has_value()) << to;
    EXPECT_NE(library.error().message.find(what), std::string::npos) << library.error().message;
  };
  says("diameter_mm: 6", "diameter_mm: -6", "t.yaml:5:18: tools[1].diameter_mm: '-6' is out of range");
  says("diameter_mm: 6", "diameter: 6",
       "t.yaml:5:5: unknown key 'diameter' in tools[1]; nearest known key: diameter_mm");
  says("shank_length_mm: 30", "shank_length_mm: 300",
       "t.yaml:8:22: tools[1].shank_length_mm: 300 mm is over length_mm");
  says("id: T9, ", "", "t.yaml:12:5: tools[2].id: missing key 'id'");
  says("id: T9", "id: ball-6", "t.yaml:12:10: tools[2].id: 'ball-6' is that of the tool at line 2");
  says("wood", "steel", "'steel' is there already");
  says("    flutes: 2\n", "", "the tool's flutes are not stated");
  says("cutting_speed_m_per_min: 150, ", "", "no speed is stated");
  says("150", "9999", "expected at most 200000");
  says("{material: wood, ", "{", "missing key 'cutting_data[2].material'");
  says(kTools, "tool: []\n", "t.yaml: is no tool library; expected a list of tools (tools:)");
  says(kTools, "tools: 3\n", "expected a list of 1 to 10000 maps");
  EXPECT_FALSE(parse_tool_library("", "t.yaml").has_value());
  EXPECT_FALSE(load_tool_library("/nowhere/t.yaml").has_value());
  // What is missing is no error, and of what follows from it nothing is said.
  const auto few =
      parse_tool_library("tools: [{id: a, cutting_length_mm: 20, shank_diameter_mm: 8}]", "t.yaml");
  ASSERT_TRUE(few.has_value()) << few.error().message;
  EXPECT_EQ(few->tools[0].lacks,
            (std::vector<std::string>{"type", "diameter_mm", "length_mm", "shank_length_mm"}));
}

TEST_F(ToolJobs, CuttingDataBoundTheChipAndTheFeedOfATooth) {
  const std::string key = "{library: bound.yaml, id: ball-6, material: steel}";
  const auto bound = [&](const std::string& data, const std::string& feeds) {
    write("bound.yaml", replaced(kTools, "plunge_mm_per_min: 250}", "plunge_mm_per_min: 250" + data + "}"));
    return job(key, "", kFeeds, feeds);
  };
  const auto limited = bound(", highest_feed_per_tooth_mm: 0.1, largest_chip_mm: 0.03", "");
  ASSERT_TRUE(limited) << limited.error().message;
  EXPECT_NEAR(limited->feeds.highest.mm_per_min(), 0.1 * 2 * limited->spindle_rpm, 1e-9);
  EXPECT_NEAR(limited->feeds.largest_chip, 0.03 * 2 * limited->spindle_rpm, 1e-9);
  // The job's own speed counts, and its own highest feed.
  const auto own = bound(", highest_feed_per_tooth_mm: 0.1, largest_chip_mm: 0.03",
                         "feeds: {spindle_rpm: 5000, highest_mm_per_min: 900}\n");
  ASSERT_TRUE(own) << own.error().message;
  EXPECT_EQ(own->feeds.highest.mm_per_min(), 900.0);
  EXPECT_NEAR(own->feeds.largest_chip, 300.0, 1e-9);
  const auto none = bound("", "");
  ASSERT_TRUE(none) << none.error().message;
  EXPECT_EQ(none->feeds.largest_chip, 0.0);
  EXPECT_EQ(none->feeds.highest, none->plan.cut_feed);
  EXPECT_NE(
      refusal(bound(", largest_chip_mm: 0.03", "feeds: {spindle_rpm: 0}\n")).find("missing key spindle_rpm"),
      std::string::npos);
}

}  // namespace
}  // namespace tiltfeed
