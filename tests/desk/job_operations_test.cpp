// The list of operations in the desk's job: what a page does with it, read back by the job's own reader.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "desk/api/job_schema.h"
#include "desk/api/job_work.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

class JobOperationsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::testing::TempDir() + "job_operations_test-" + std::to_string(::getpid());
    std::filesystem::create_directories(folder_ + "/work");
    std::ostringstream text;
    text << std::ifstream(std::string(SOURCE_DIR) + "/config/jobs/pin_operations.yaml").rdbuf();
    text_ = text.str();
    const std::string profile = "../machines/";
    text_.replace(text_.find(profile), profile.size(), std::string(SOURCE_DIR) + "/config/machines/");
    open(text_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void open(const std::string& text) {
    std::ofstream(path()) << text;
    work_ = std::make_unique<JobWork>(folder_ + "/work");
    const auto opened = work_->open(path());
    ASSERT_TRUE(opened.has_value()) << opened.error().message;
  }
  std::string path() const { return folder_ + "/job.yaml"; }
  json told() const { return json::parse(work_->describe()); }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    const json operations = told()["operations"];
    for (const json& one : operations) all.push_back(one["name"]);
    return all;
  }
  /// Saved, and read by the command line's reader.
  std::vector<config::Job> saved() {
    const auto kept = work_->save();
    EXPECT_TRUE(kept.has_value()) << kept.error().message << "\n" << work_->describe();
    auto jobs = config::load_operations(path(), {});
    EXPECT_TRUE(jobs.has_value());
    return jobs ? *jobs : std::vector<config::Job>{};
  }

  std::string folder_, text_;
  std::unique_ptr<JobWork> work_;
};

TEST_F(JobOperationsTest, are_told_with_tool_and_what_they_state_themselves) {
  EXPECT_EQ(names(), (std::vector<std::string>{"semi-finish", "finish", "middle once more"}));
  const json all = told()["operations"];
  EXPECT_EQ(all[0]["tool"], 1);
  EXPECT_EQ(all[0]["cutter"]["diameter_mm"], 4.0);
  EXPECT_EQ(all[1]["cutter"]["diameter_mm"], 2.0);
  EXPECT_EQ(all[0]["cutter_type"], "ball");
  EXPECT_EQ(all[2]["axis"], "line");
  EXPECT_EQ(all[2]["own"], json({"pattern", "containment", "tolerance_mm", "program.tool"}));
  EXPECT_TRUE(work_->is_right());
  EXPECT_EQ(work_->operation("finish")->plan.cutter.diameter, 2.0);
  EXPECT_EQ(work_->operation("nobody"), nullptr);
}

TEST_F(JobOperationsTest, are_moved_copied_and_taken_out_with_their_remarks) {
  ASSERT_TRUE(work_->move_operation(3, 1).has_value());
  EXPECT_EQ(names(), (std::vector<std::string>{"middle once more", "semi-finish", "finish"}));
  ASSERT_TRUE(work_->copy_operation(2, "semi again").has_value());
  EXPECT_EQ(names(), (std::vector<std::string>{"middle once more", "semi-finish", "semi again", "finish"}));
  EXPECT_FALSE(work_->copy_operation(2, "finish").has_value()) << "a name that is taken";
  EXPECT_FALSE(work_->copy_operation(2, "a/b").has_value());
  ASSERT_TRUE(work_->take_out_operation(1).has_value());
  EXPECT_NE(work_->text().find("  # - name: middle once more\n"), std::string::npos);
  EXPECT_NE(work_->text().find("# What each has by itself"), std::string::npos);
  const std::vector<config::Job> jobs = saved();
  ASSERT_EQ(jobs.size(), 3u);
  EXPECT_EQ(jobs[1].operation.name, "semi again");
  EXPECT_EQ(config::describe(jobs[1]).size(), config::describe(jobs[0]).size() -
                                                  std::string("semi-finish").size() +
                                                  std::string("semi again").size());
}

TEST_F(JobOperationsTest, a_section_becomes_its_own_and_shared_again) {
  ASSERT_TRUE(work_->set_own(2, "cutter", true).has_value());
  const json own = told()["operations"][1]["own"];
  EXPECT_EQ(std::count(own.begin(), own.end(), json("cutter")), 1) << own;
  ASSERT_TRUE(work_->is_right()) << work_->describe();
  EXPECT_EQ(work_->operation("finish")->plan.cutter.diameter, 2.0) << "as the job says it for all";
  ASSERT_TRUE(work_->edit({{"operations[2].cutter.diameter_mm", "3"}}).has_value());
  ASSERT_TRUE(work_->edit({{"operations[2].program.tool", "3"}}).has_value());
  EXPECT_EQ(work_->operation("finish")->plan.cutter.diameter, 3.0);
  EXPECT_EQ(work_->operation("middle once more")->plan.cutter.diameter, 2.0);
  ASSERT_TRUE(work_->set_own(2, "cutter", false).has_value());
  ASSERT_TRUE(work_->edit({{"operations[2].program.tool", "2"}}).has_value());
  ASSERT_TRUE(work_->is_right()) << work_->describe();
  EXPECT_EQ(work_->operation("finish")->plan.cutter.diameter, 2.0);
  EXPECT_FALSE(work_->set_own(2, "machine", true).has_value());
  EXPECT_FALSE(work_->set_own(4, "cutter", true).has_value());
  EXPECT_FALSE(work_->set_own(0, "cutter", true).has_value());
}

/// Each section of the job, made an operation's own, leaves the operation what it was.
TEST_F(JobOperationsTest, what_becomes_its_own_reads_as_what_was_shared) {
  const std::string before = config::describe(*work_->operation("middle once more"));
  for (const char* section : {"axis", "cutter", "feeds", "points", "guards", "links", "stock", "clearance_mm",
                              "approach_mm", "program.coolant"}) {
    const auto done = work_->set_own(3, section, true);
    ASSERT_TRUE(done.has_value()) << section << ": " << done.error().message;
    ASSERT_TRUE(work_->is_right()) << section << ": " << work_->describe();
    EXPECT_EQ(config::describe(*work_->operation("middle once more")), before) << section << "\n"
                                                                               << work_->text();
  }
  for (const char* section : {"axis", "cutter", "feeds", "points", "clearance_mm", "program.coolant"}) {
    ASSERT_TRUE(work_->set_own(3, section, false).has_value()) << section;
    EXPECT_EQ(config::describe(*work_->operation("middle once more")), before) << section << "\n"
                                                                               << work_->text();
  }
}

TEST_F(JobOperationsTest, a_job_of_one_becomes_two) {
  std::ostringstream pin;
  pin << std::ifstream(std::string(SOURCE_DIR) + "/config/jobs/pin.yaml").rdbuf();
  std::string text = pin.str();
  const std::string profile = "../machines/";
  text.replace(text.find(profile), profile.size(), std::string(SOURCE_DIR) + "/config/machines/");
  open(text);
  EXPECT_TRUE(told()["operations"].empty());
  EXPECT_FALSE(work_->set_own(1, "cutter", true).has_value());
  ASSERT_TRUE(work_->copy_operation(0, "once more").has_value());
  EXPECT_EQ(names(), (std::vector<std::string>{"first", "once more"}));
  EXPECT_TRUE(work_->is_right()) << work_->describe();
  EXPECT_EQ(work_->text().rfind(text.substr(0, text.find("\nmachine:")), 0), 0u) << "all else is as it was";
  EXPECT_EQ(saved().size(), 2u);
  ASSERT_TRUE(work_->take_out_operation(1).has_value());
  EXPECT_FALSE(work_->take_out_operation(1).has_value()) << "the only one";
}

TEST_F(JobOperationsTest, the_schema_of_an_operation_has_its_values) {
  const auto schema = job_schema(work_->text(), 1), shared = job_schema(work_->text(), 0);
  ASSERT_TRUE(schema.has_value() && shared.has_value());
  EXPECT_FALSE(job_schema(work_->text(), 4).has_value());
  const auto value = [](const std::string& of, const std::string& key) -> json {
    const json keys = json::parse(of)["keys"];
    for (const json& fact : keys)
      if (fact["key"] == key) return fact.value("value", json());
    return nullptr;
  };
  EXPECT_EQ(value(*schema, "cutter.diameter_mm"), "4");
  EXPECT_EQ(value(*shared, "cutter.diameter_mm"), "2");
  EXPECT_EQ(value(*schema, "axis.mode"), "line");
  EXPECT_EQ(value(*schema, "program.tool"), "1");
  EXPECT_EQ(json::parse(*schema)["name"], "semi-finish");
}

TEST_F(JobOperationsTest, one_library_serves_all_and_no_other) {
  std::ofstream(folder_ + "/tools, one.yaml")
      << "tools: [{id: pin, type: ball, diameter_mm: 3, length_mm: 90, shank_length_mm: 40, number: 2}]\n";
  std::string text = text_;
  const std::string cutter = "cutter: {type: ball, diameter_mm: 2, length_mm: 120, shank_length_mm: 40}";
  text.replace(text.find(cutter), cutter.size(), "cutter: {library: \"tools, one.yaml\", id: pin}");
  open(text);
  EXPECT_TRUE(work_->is_right()) << work_->describe();
  EXPECT_EQ(work_->operation("finish")->plan.cutter.diameter, 3.0);
  EXPECT_EQ(work_->operation("semi-finish")->plan.cutter.diameter, 4.0);
  ASSERT_TRUE(work_->set_own(2, "cutter", true).has_value());
  EXPECT_TRUE(work_->is_right()) << work_->describe();
  ASSERT_TRUE(work_->edit({{"operations[2].cutter.library", "/etc/passwd"}}).has_value());
  EXPECT_FALSE(work_->is_right());
  EXPECT_NE(work_->describe().find("the desk works with 'tools, one.yaml'"), std::string::npos)
      << work_->describe();
}

}  // namespace
}  // namespace tiltfeed::desk
