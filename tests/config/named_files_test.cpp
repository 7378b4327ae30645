// Files that a job of somebody else names: nothing of them is read, and nobody is told whether they are
// there.

#include "config/named_files.h"

#include <gtest/gtest.h>

#include "config/job.h"
#include "config/tool_library.h"
#include "tests/texts/bad_text.h"
#include "tests/texts/folder.h"
#include "tests/texts/job_text.h"

namespace tiltfeed {
using namespace config;
namespace {

constexpr const char* kSecretWord = "hunter2";
const std::string kCutterHere = "cutter: {type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}";

TEST(NamedFiles, AreFoundByTheirKeys) {
  const auto tree = parse_yaml(
      "cutter: {library: a}\n"
      "operations:\n"
      "  - {name: one, cutter: {library: b}}\n"
      "  - {name: two, cutter: {type: ball}}\n"
      "  - {name: three, cutter: {library: [c]}}\n"
      "fixtures: [{shape: box}, {shape: stl, stl: d}, {shape: box, stl: e}]\n"
      "blank: {file: f}\n",
      "job.yaml");
  ASSERT_TRUE(tree) << tree.error().message;
  std::string found;
  for (const NamedFileKey& file : files_named_in(*tree)) found += file.key + "=" + file.node->text + " ";
  EXPECT_EQ(found,
            "cutter.library=a operations[1].cutter.library=b operations[3].cutter.library= fixtures[2].stl=d "
            "fixtures[3].stl=e blank.file=f ");
}

TEST(NamedFiles, OfAJobOfSomebodyElseAreErrorsWhereverTheyStand) {
  const Folder folder("named_files");
  folder.write("secret", std::string("password: ") + kSecretWord + "\n");
  folder.write("tools.yaml",
               "tools: [{id: six, type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}]\n");
  struct Case {
    std::string from, to, key;  ///< FILE stands for the file's name
  };
  const std::string operations =
      "operations:\n  - {name: one}\n  - {name: two, cutter: {library: FILE, id: six}}\n";
  const Case cases[] = {
      {kCutterHere, "cutter: {library: FILE, id: six}", "cutter.library"},
      {"", operations, "cutter.library"},
      {"", "fixtures: [{name: vice, shape: stl, stl: FILE}]\n", "fixtures[1].stl"},
      {"", "blank: {shape: file, file: FILE}\n", "blank.file"},
  };
  for (const Case& one : cases) {
    std::string told;
    for (const char* name : {"secret", "tools.yaml", "nowhere"}) {
      const std::string file = folder.path + "/" + name;
      const std::string with = replaced(one.to, "FILE", file);
      std::string text = one.from.empty() ? kGoodJob + with : replaced(kGoodJob, one.from, with);
      text = replaced(text, "../machines/", SOURCE_DIR "/config/machines/");
      const std::string job = folder.write("job.yaml", text);
      const auto jobs = load_operations(job, {.closed = true});
      ASSERT_FALSE(jobs) << with;
      std::string said = jobs.error().message;
      EXPECT_EQ(jobs.error().code, Code::kInput) << said;
      EXPECT_NE(said.find(one.key + ": the file '" + file.substr(0, 10)), std::string::npos) << said;
      EXPECT_EQ(said.find(kSecretWord), std::string::npos) << said;
      // There or not, right or not: nothing else tells them apart.
      said = replaced(said, name, "FILE");
      if (told.empty()) told = said;
      EXPECT_EQ(said, told);
    }
  }
}

TEST(NamedFiles, OfAnotherKindThanAToolLibraryTellNothing) {
  const char* const texts[] = {
      "root:x:0:0:hunter2:/root:/bin/bash\ndaemon:x:1:1:hunter2:/usr/sbin:/usr/sbin/nologin\n",
      "hunter2\n",
      "password: hunter2\n",
      "hunter2: [1, 2]\n",
      "user: a\nhunter2: b\nhunter2: c\n",
      "a: &hunter2 b\n",
      "a: *hunter2\n",
      "a: !hunter2 b\n",
      "- hunter2\n",
      "{\"hunter2\": \"hunter2\"",
      "hunter2: a: b\n",
      "-----BEGIN PRIVATE KEY-----\nhunter2\n-----END PRIVATE KEY-----\n",
      "db:5432:shop:shop:hunter2\n",
      "\thunter2\n",
      "--- hunter2\n--- hunter2\n",
  };
  for (const char* text : texts) {
    const auto library = parse_tool_library(text, "/etc/secret");
    ASSERT_FALSE(library) << text;
    EXPECT_EQ(library.error().message, "/etc/secret: is no tool library; expected a list of tools (tools:)")
        << text;
  }
  // What is wrong in a library is told in full.
  const auto typo = parse_tool_library("tools: [{id: a, diamter_mm: 6}]\n", "t.yaml");
  ASSERT_FALSE(typo);
  EXPECT_NE(typo.error().message.find("'diamter_mm'"), std::string::npos) << typo.error().message;
  const auto twice = parse_tool_library("tools:\n  - id: a\n    id: b\n", "t.yaml");
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().message.find("t.yaml:3:5: duplicate key 'id'"), std::string::npos)
      << twice.error().message;
}

}  // namespace
}  // namespace tiltfeed
