#include "desk/api/job_work.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace tiltfeed::desk {
using namespace pathgen;
using namespace config;
namespace {

class JobWorkTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::testing::TempDir() + "job_work_test-" + std::to_string(::getpid());
    std::filesystem::create_directories(folder_ + "/work");
    text_ = read(std::string(SOURCE_DIR) + "/config/jobs/pin.yaml");
    const std::string profile = "../machines/";
    text_.replace(text_.find(profile), profile.size(), std::string(SOURCE_DIR) + "/config/machines/");
    write(path(), text_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path() const { return folder_ + "/pin.yaml"; }
  static std::string read(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
  static void write(const std::string& file, const std::string& text) { std::ofstream(file) << text; }
  /// The text with a line of its own before `at`.
  std::string with(const std::string& line, const std::string& at) const {
    std::string changed = text_;
    return changed.insert(changed.find(at), line);
  }

  std::string folder_, text_;
};

TEST(JobErrors, are_split_into_place_and_message) {
  const auto errors = split_errors(
      "/a/job.yaml:20:3: unknown key 'x'; nearest: y\n/a/job.yaml:4:1: cutter: missing\n/a/job.yaml: and 3 "
      "more\nno place",
      "/a/job.yaml");
  ASSERT_EQ(errors.size(), 4u);
  EXPECT_EQ(errors[0].line, 20);
  EXPECT_EQ(errors[0].column, 3);
  EXPECT_EQ(errors[0].message, "unknown key 'x'; nearest: y");
  EXPECT_EQ(errors[1].line, 4);
  EXPECT_EQ(errors[1].message, "cutter: missing");
  EXPECT_EQ(errors[2].line, 0);
  EXPECT_EQ(errors[2].message, "and 3 more");
  EXPECT_EQ(errors[3].message, "no place");
}

TEST_F(JobWorkTest, takes_another_machine_that_comes_with_the_program) {
  JobWork work(folder_ + "/work");
  ASSERT_TRUE(work.open(path()).has_value());
  ASSERT_TRUE(work.job().machine.model.rotary.present);
  EXPECT_FALSE(work.choose_machine("../../etc/passwd").has_value());
  EXPECT_EQ(work.text(), text_);
  const auto chosen = work.choose_machine("vmc-bhead-bc");
  ASSERT_TRUE(chosen.has_value()) << chosen.error().message;
  EXPECT_EQ(work.job().machine.model.name, "vmc-bhead-bc");
  // Only that value has changed.
  std::string expected = text_;
  const std::size_t machine = expected.find(std::string(SOURCE_DIR) + "/config/machines/");
  const std::size_t end = expected.find('\n', machine);
  const std::string now = work.text();
  EXPECT_EQ(now.substr(0, machine - 2), expected.substr(0, machine - 2));
  EXPECT_NE(now.find("vmc-bhead-bc.yaml", machine - 2), std::string::npos) << now;
  EXPECT_EQ(now.substr(now.size() - (expected.size() - end)), expected.substr(end));
  // Saved with its profile beside it, the job is planned by the command line.
  ASSERT_TRUE(work.is_right()) << work.describe();
  const auto saved = work.save();
  ASSERT_TRUE(saved.has_value()) << saved.error().message;
  EXPECT_EQ(read(folder_ + "/vmc-bhead-bc.yaml"),
            read(std::string(SOURCE_DIR) + "/config/machines/vmc-bhead-bc.yaml"));
  const auto loaded = load_job(path());
  ASSERT_TRUE(loaded.has_value()) << loaded.error().message;
  EXPECT_EQ(loaded->machine.model.name, "vmc-bhead-bc");
}

TEST_F(JobWorkTest, does_not_write_over_another_machine_of_that_name) {
  write(folder_ + "/generic-ac.yaml", "name: mine\n");
  JobWork work(folder_ + "/work");
  ASSERT_TRUE(work.open(path()).has_value());
  ASSERT_TRUE(work.choose_machine("generic-ac").has_value());
  const auto saved = work.save();
  ASSERT_FALSE(saved.has_value());
  EXPECT_NE(saved.error().message.find("not written over"), std::string::npos);
  EXPECT_EQ(read(folder_ + "/generic-ac.yaml"), "name: mine\n");
}

TEST_F(JobWorkTest, works_with_the_tool_library_of_the_file_and_no_other) {
  const std::string tools =
      "tools: [{id: pin, type: ball, diameter_mm: 3, length_mm: 90, shank_length_mm: 40}]\n";
  write(folder_ + "/tools.yaml", tools);
  write(folder_ + "/work/tools.yaml", "no library: at all\n");
  const std::size_t cutter = text_.find("\ncutter:"), next = text_.find("\naxis:");
  ASSERT_LT(cutter, next);
  const std::string typed = text_;
  text_.replace(cutter, next - cutter, "\ncutter: {library: tools.yaml, id: pin}");
  write(path(), text_);
  JobWork work(folder_ + "/work");
  const auto opened = work.open(path());
  ASSERT_TRUE(opened.has_value()) << opened.error().message;
  EXPECT_TRUE(work.is_right()) << work.describe();
  EXPECT_EQ(work.job().plan.cutter.diameter, 3.0);
  EXPECT_EQ(work.text(), text_);
  // What other processes get is whole by itself.
  const auto there = load_job(work.file());
  EXPECT_TRUE(there.has_value() || there.error().message.find("cutter") == std::string::npos)
      << there.error().message;
  EXPECT_EQ(read(work.file()).find("tools.yaml"), std::string::npos);
  // Another one is refused without a look at it.
  std::string other = text_;
  other.replace(other.find("tools.yaml"), 10, "work/tools.yaml");
  ASSERT_TRUE(work.set_text(other).has_value());
  EXPECT_FALSE(work.is_right());
  EXPECT_NE(work.describe().find("the desk works with 'tools.yaml'"), std::string::npos) << work.describe();
  EXPECT_FALSE(work.whole(other).has_value());
  // So is one where the file named none.
  write(path(), typed);
  JobWork plain(folder_ + "/work");
  ASSERT_TRUE(plain.open(path()).has_value());
  ASSERT_TRUE(plain.set_text(text_).has_value());
  EXPECT_NE(plain.describe().find("the desk works with no library"), std::string::npos) << plain.describe();
}

TEST_F(JobWorkTest, tells_errors_at_their_line_and_saves_only_what_is_right) {
  JobWork work(folder_ + "/work");
  ASSERT_TRUE(work.open(path()));
  EXPECT_TRUE(work.is_right());
  const std::uint64_t first = work.id();
  const std::string wrong = with("nonsense_mm: 3\n", "tolerance_mm:");
  ASSERT_TRUE(work.set_text(wrong));
  EXPECT_GT(work.id(), first);
  EXPECT_FALSE(work.is_right());
  const auto line =
      std::count(wrong.begin(), wrong.begin() + static_cast<std::ptrdiff_t>(wrong.find("nonsense")), '\n') +
      1;
  EXPECT_NE(work.describe().find("\"line\":" + std::to_string(line)), std::string::npos) << work.describe();
  EXPECT_FALSE(work.save());
  EXPECT_EQ(read(path()), text_) << "untouched";
  const std::string right = with("# a remark\n", "tolerance_mm:");
  ASSERT_TRUE(work.set_text(right));
  EXPECT_TRUE(work.is_right()) << work.describe();
  EXPECT_EQ(read(path()), text_) << "not before it is saved";
  ASSERT_TRUE(work.save());
  EXPECT_EQ(read(path()), right) << "remarks and all";
}

TEST_F(JobWorkTest, takes_no_path_from_the_text) {
  JobWork work(folder_ + "/work");
  ASSERT_TRUE(work.open(path()));
  const std::string stl = work.stl(), machine = work.machine();
  for (const char* key : {"stl: ", "machine: "}) {
    std::string text = text_;
    const std::size_t at = text.find(key) + std::string(key).size();
    text.replace(at, text.find('\n', at) - at, "/etc/passwd");
    ASSERT_TRUE(work.set_text(text));
    EXPECT_FALSE(work.is_right()) << key;
    EXPECT_NE(work.describe().find("the desk works with"), std::string::npos) << work.describe();
    EXPECT_EQ(work.stl(), stl);
    EXPECT_EQ(work.machine(), machine);
  }
}

TEST_F(JobWorkTest, takes_files_of_fixtures_and_blank_from_where_the_job_lies_and_no_other) {
  std::filesystem::copy_file(std::string(SOURCE_DIR) + "/config/jobs/pin.yaml", folder_ + "/vice.stl");
  write(folder_ + "/secret", "hunter2\n");
  const std::string plain = text_;
  text_ += "fixtures:\n  - {name: vice, shape: stl, stl: vice.stl}\nblank: {shape: file, file: vice.stl}\n";
  write(path(), text_);
  JobWork work(folder_ + "/work");
  ASSERT_TRUE(work.open(path()));
  EXPECT_TRUE(work.is_right()) << work.describe();
  ASSERT_EQ(work.job().fixtures.size(), 1u);
  EXPECT_EQ(work.job().fixtures[0].shape.stl, folder_ + "/vice.stl");
  EXPECT_EQ(work.job().blank->path, folder_ + "/vice.stl");
  EXPECT_EQ(work.text(), text_);
  const std::string others[] = {"fixtures:\n  - {name: vice, shape: stl, stl: FILE}\n",
                                "blank: {shape: file, file: FILE}\n",
                                "operations: [{name: a, cutter: {library: FILE, id: a}}]\n"};
  for (const std::string& other : others)
    for (const std::string& name : {folder_ + "/secret", std::string("secret"), folder_ + "/nowhere"}) {
      std::string text = other;
      text = plain + text.replace(text.find("FILE"), 4, name);
      ASSERT_TRUE(work.set_text(text));
      EXPECT_FALSE(work.is_right()) << text;
      const std::string said = work.describe();
      EXPECT_NE(said.find("to take another file, change the job file"), std::string::npos) << said;
      EXPECT_EQ(said.find("hunter2"), std::string::npos) << said;
      EXPECT_EQ(said.find("not a file"), std::string::npos) << "whether it is there: " << said;
      EXPECT_FALSE(work.whole(text).has_value());
    }
}

TEST_F(JobWorkTest, works_on_nothing_until_a_job_is_open) {
  JobWork work(folder_ + "/work");
  EXPECT_EQ(work.describe(), "null");
  EXPECT_FALSE(work.set_text(text_));
  EXPECT_FALSE(work.save());
  write(path(), "part: 3\n");
  EXPECT_FALSE(work.open(path()));
  EXPECT_FALSE(work.is_open());
}

}  // namespace
}  // namespace tiltfeed::desk
