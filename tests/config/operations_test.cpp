// A job's list of operations: each is the job that it would be by itself.

#include <gtest/gtest.h>

#include <sstream>

#include "config/job.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

const std::string kSetupLines =
    "setup: {part_zero_mm: [1, 2, 3]}\nmachine: " SOURCE_DIR "/config/machines/generic-ac.yaml\n";
const std::string kPartLines = "part: {name: p, stl: p.stl}\n";
const std::string kPointLines = "axis: {mode: point, sense: outward}\n";
const std::string kFixedLines = "axis: {mode: fixed}\n";
const std::string kSixLines = "cutter: {type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}\n";
const std::string kTwoLines = "cutter: {type: ball, diameter_mm: 2, length_mm: 90, shank_length_mm: 20}\n";
const std::string kFeedsLines = "feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300, spindle_rpm: 9000}\n";
const std::string kWaysLines = "clearance_mm: 5\napproach_mm: 1\n";

/// Of a list: "- name: NAME" and lines with a key each.
std::string item(const std::string& name, const std::string& lines) {
  std::string text = "  - name: " + name + "\n";
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);) text += "    " + line + "\n";
  return text;
}

/// All that is understood but for where it stands.
std::string understood(const Job& job) {
  std::istringstream in(describe(job));
  std::string text;
  for (std::string line; std::getline(in, line);)
    if (!line.starts_with("job:") && !line.starts_with("operation:")) text += line + "\n";
  return text;
}

class Operations : public testing::Test {
 protected:
  Result<std::vector<Job>> load(const std::string& text, const std::string& operation = "") const {
    return load_operations(folder_.write("job.yaml", text), {.operation = operation});
  }
  std::string error(const std::string& text, const std::string& operation = "") const {
    const auto jobs = load(text, operation);
    EXPECT_FALSE(jobs) << "taken:\n" << text;
    return jobs ? "" : jobs.error().message.substr(folder_.path.size() + 1);
  }
  std::string alone(const std::string& text) const {
    const Result<Job> job = load_job(folder_.write("alone.yaml", text));
    EXPECT_TRUE(job) << job.error().message;
    return job ? understood(*job) : "";
  }

  const Folder folder_{"operations"};
  const std::string shared_ = kPartLines + kPointLines + kFeedsLines + kWaysLines + kSetupLines +
                              "tolerance_mm: 0.02\nprogram: {number: 7, work_offset: 2, coolant: mist}\n" +
                              kSixLines;
  const std::string rough_ =
      "pattern: {kind: rough, side_step_mm: 2, step_down_mm: 1}\nallowance_mm: 0.5\n"
      "tolerance_mm: 0.1\nprogram: {tool: 3}\n";
  const std::string finish_ = kFixedLines + kTwoLines +
                              "pattern: {side_step_mm: 0.2}\nprogram: {tool: 4, coolant: flood}\n" +
                              "feeds: {cut_mm_per_min: 400, plunge_mm_per_min: 200}\n";
};

TEST_F(Operations, EachIsTheJobThatItIsByItself) {
  const auto jobs = load(shared_ + "operations:\n" + item("rough it", rough_) + item("finish", finish_));
  ASSERT_TRUE(jobs) << jobs.error().message;
  ASSERT_EQ(jobs->size(), 2u);
  EXPECT_EQ((*jobs)[0].operation.name, "rough it");
  EXPECT_EQ((*jobs)[1].operation.number, 2u);
  EXPECT_EQ((*jobs)[1].operation.count, 2u);
  const std::string common = kPartLines + kWaysLines + kSetupLines;
  EXPECT_EQ(understood((*jobs)[0]),
            alone(common + kPointLines + kFeedsLines + kSixLines +
                  "pattern: {kind: rough, side_step_mm: 2, step_down_mm: 1}\nallowance_mm: 0.5\n"
                  "tolerance_mm: 0.1\nprogram: {number: 7, work_offset: 2, coolant: mist, tool: 3}\n"));
  EXPECT_EQ(understood((*jobs)[1]),
            alone(common + kFixedLines + kTwoLines + "pattern: {side_step_mm: 0.2}\ntolerance_mm: 0.02\n" +
                  "feeds: {cut_mm_per_min: 400, plunge_mm_per_min: 200}\n"
                  "program: {number: 7, work_offset: 2, coolant: flood, tool: 4}\n"));
  EXPECT_EQ((*jobs)[1].setup.tool_length, 90.0);
}

TEST_F(Operations, OneIsFoundByItsName) {
  const std::string text = shared_ + "operations:\n" + item("rough it", rough_) + item("finish", finish_);
  const auto job = load(text, "finish");
  ASSERT_TRUE(job) << job.error().message;
  ASSERT_EQ(job->size(), 1u);
  EXPECT_EQ(job->front().program.tool, 4);
  EXPECT_EQ(job->front().operation.number, 2u);
  EXPECT_EQ(error(text, "finishing"),
            "job.yaml: there is no operation 'finishing'; its operations are rough it, finish");
  EXPECT_EQ(error(shared_ + "pattern: {side_step_mm: 1}\n", "finish"),
            "job.yaml: there is no operation 'finish'; the job has no list of operations");
  const Result<Job> one = load_job(folder_.write("job.yaml", text));
  ASSERT_FALSE(one);
  EXPECT_EQ(one.error().code, Code::kUsage);
  EXPECT_NE(one.error().message.find("several operations (rough it, finish)"), std::string::npos);
}

TEST_F(Operations, RestIsWhatThoseBeforeLeave) {
  const std::string rest = finish_ + "rest: {more_than_mm: 0.2}\n";
  const auto jobs = load(shared_ + "operations:\n" + item("rough it", rough_) + item("finish", rest));
  ASSERT_TRUE(jobs) << jobs.error().message;
  EXPECT_EQ((*jobs)[0].plan.rest_more_than, 0.0);
  EXPECT_EQ((*jobs)[1].plan.rest_more_than, 0.2);
  EXPECT_NE(describe((*jobs)[1]).find("\nrest.more_than_mm: 0.2\n"), std::string::npos);
  EXPECT_EQ(describe((*jobs)[0]).find("rest."), std::string::npos);
  EXPECT_EQ(error(shared_ + "operations:\n" + item("finish", rest) + item("rough it", rough_)),
            "job.yaml: rest.more_than_mm: no operation comes before 'finish'; leave rest out there, or put "
            "another operation first");
  EXPECT_NE(error(shared_ + "pattern: {side_step_mm: 1}\nrest: {more_than_mm: 0.2}\n")
                .find("no operation comes before this one, the job is one"),
            std::string::npos);
  const std::string whole = shared_ + "operations:\n" + item("rough it", rough_) + item("finish", rest);
  for (const char* wrong : {"0.001", "51"}) {
    std::string text = whole;
    text.replace(text.find("more_than_mm: 0.2") + 14, 3, wrong);
    EXPECT_NE(error(text).find("rest.more_than_mm"), std::string::npos) << wrong;
  }
  EXPECT_NE(
      error(shared_ + "operations:\n" + item("rough it", rough_) +
            item("finish", kTwoLines +
                               "pattern: {side_step_mm: 0.2}\nprogram: {tool: 4}\n"
                               "axis: {mode: free, plane_normals: [[0, 0, 1]]}\nrest: {more_than_mm: 0.2}\n"))
          .find("not made in the axis mode free"),
      std::string::npos);
}

TEST_F(Operations, AJobWithoutAListIsOne) {
  const auto jobs = load(shared_ + "pattern: {side_step_mm: 1}\n");
  ASSERT_TRUE(jobs) << jobs.error().message;
  ASSERT_EQ(jobs->size(), 1u);
  EXPECT_EQ(jobs->front().operation.name, "");
}

TEST_F(Operations, WhatIsWrongIsToldWithItsPlace) {
  const std::string head = shared_ + "operations:\n";
  const auto line = [](std::size_t n) { return "job.yaml:" + std::to_string(n); };
  const std::size_t first = static_cast<std::size_t>(std::count(head.begin(), head.end(), '\n')) + 1;
  const struct {
    std::string list, place, said;
  } cases[] = {
      {item("a", rough_) + item("a", finish_), line(first + 5), "two operations have this name"},
      {item("a", rough_ + "part: {name: q, stl: q.stl}"), line(first + 5), "unknown key 'part'"},
      {item("a", rough_ + "setup: {part_zero_mm: [0, 0, 0]}"), line(first + 5), "unknown key 'setup'"},
      {item("a", "pattern: {side_step_mm: 1}\nprogram: {number: 2}"), line(first + 2),
       "unknown key 'number'"},
      {item("a", "pattern: {side_step_mm: 1}\nprogram: {work_offset: 2}"), line(first + 2),
       "unknown key 'work_offset'"},
      {item("a", "allowance_mm: 1"), line(first), "missing key 'pattern'"},
      {item("a", "pattern: {side_step_mm: 1, step: 2}"), line(first + 1), "unknown key 'step'"},
      {item("a!", "pattern: {side_step_mm: 1}"), line(first), "name"},
      {"  - pattern: {side_step_mm: 1}\n", line(first), "missing key 'operations[1].name'"},
      {"  []\n", line(first), "operations"},
      {"  5\n", line(first), "operations"},
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(one.list);
    const std::string said = error(head + one.list);
    EXPECT_TRUE(said.starts_with(one.place)) << said;
    EXPECT_NE(said.find(one.said), std::string::npos) << said;
  }
  // A fault of the shared part is told once, those of operations each.
  const std::string many = error(
      kPartLines + "tolerance_mm: 7\n" + kPointLines + kFeedsLines + kWaysLines + kSetupLines + kSixLines +
      "operations:\n" + item("a", "pattern: {side_step_mm: 0}") + item("b", "pattern: {side_step_mm: -1}"));
  EXPECT_EQ(std::count(many.begin(), many.end(), '\n'), 2) << many;
}

TEST_F(Operations, AToolNumberIsOneCutter) {
  const std::string head = kPartLines + kPointLines + kFeedsLines + kWaysLines + kSetupLines +
                           "pattern: {side_step_mm: 1}\noperations:\n";
  EXPECT_NE(
      error(head + item("a", kSixLines + "program: {tool: 3}") + item("b", kTwoLines + "program: {tool: 3}"))
          .find("under one tool number, 3"),
      std::string::npos);
  EXPECT_NE(
      error(head + item("a", kSixLines + "program: {tool: 3}") + item("b", kTwoLines)).find("of 'b' is 0"),
      std::string::npos);
  EXPECT_TRUE(load(head + item("a", kSixLines) + item("b", kSixLines)))
      << "the tool in the spindle does both";
}

TEST_F(Operations, TheyAreGroupedByToolWhereThatIsAsked) {
  const std::string six = kSixLines + "program: {tool: 3}", two = kTwoLines + "program: {tool: 4}";
  const std::string text = kPartLines + kPointLines + kFeedsLines + kWaysLines + kSetupLines +
                           "pattern: {side_step_mm: 1}\noperations:\n" + item("a", six) + item("b", two) +
                           item("c", six) + item("d", two) + "operation_order: ";
  const auto names = [&](const std::string& order) {
    const auto jobs = load(text + order + "\n");
    EXPECT_TRUE(jobs) << jobs.error().message;
    std::string all;
    for (const Job& job : jobs.value_or(std::vector<Job>{}))
      all += job.operation.name + std::to_string(job.operation.number);
    return all;
  };
  EXPECT_EQ(names("listed"), "a1b2c3d4");
  EXPECT_EQ(names("by_tool"), "a1c2b3d4");
  const auto one = load(text + "by_tool\n", "c");
  ASSERT_TRUE(one) << one.error().message;
  EXPECT_EQ(one->front().operation.number, 2u);
  EXPECT_NE(
      error(shared_ + "pattern: {side_step_mm: 1}\noperation_order: listed\n").find("without operations"),
      std::string::npos);
}

TEST_F(Operations, ToolsOfALibraryAreWrittenOut) {
  folder_.write("tools.yaml",
                "tools:\n  - id: six\n    type: ball\n    diameter_mm: 6\n    length_mm: 100\n    "
                "shank_length_mm: 30\n    number: 3\n    cutting_data:\n      - {material: steel, "
                "cut_mm_per_min: 800, plunge_mm_per_min: 250, spindle_rpm: 7000}\n");
  const std::string text = kPartLines + kPointLines + kWaysLines + kSetupLines + kFeedsLines +
                           "pattern: {side_step_mm: 1}\noperations:\n" +
                           item("a", "cutter: {library: tools.yaml, id: six, material: steel}") +
                           item("b", kTwoLines + "program: {tool: 4}");
  const auto jobs = load(text);
  ASSERT_TRUE(jobs) << jobs.error().message;
  const auto out = with_tool_written_out(text, folder_.path + "/job.yaml", {});
  ASSERT_TRUE(out) << out.error().message;
  EXPECT_EQ(out->find("library"), std::string::npos) << *out;
  const auto again = load(*out);
  ASSERT_TRUE(again) << again.error().message << "\n" << *out;
  for (std::size_t i = 0; i < 2; ++i) {
    Job before = (*jobs)[i];
    before.tools_path = before.material = "";
    EXPECT_EQ(understood((*again)[i]), understood(before));
  }
}

}  // namespace
}  // namespace tiltfeed
