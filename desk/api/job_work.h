#pragma once
// The job on the desk: its text, what is wrong with it, and the files that it is planned with.

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "config/job.h"
#include "config/yaml_edit.h"
#include "desk/http/http_message.h"

namespace tiltfeed::desk {

/// A complaint about the job's text; line and column from 1, 0 where it is about no place of it.
struct JobError {
  int line = 0, column = 0;
  std::string message;
};

/// The errors in what load_job() said of the file `path`: one each "path:line:column: message".
std::vector<JobError> split_errors(const std::string& said, const std::string& path);

/// What a job for a part that has none begins with.
struct NewDeskJob {
  std::string part;     ///< the STL's name, without its folder
  std::string folder;   ///< where the STL was opened from; empty: it came through the browser
  std::string unit;     ///< as PartWork has it
  std::string machine;  ///< a profile that comes with the program
  std::string cutter;   ///< as parse_cutter() takes it
};

/// Part and machine are files of this computer that the user named at the start, whatever the text says of
/// them since: no path comes from a browser.
class JobWork {
 public:
  /// `folder`: where the text is kept that is being worked on.
  explicit JobWork(std::string folder) : folder_(folder), file_(folder + "/job.yaml") {}

  /// The job file that was named at the start. Errors: as load_job(): then there is nothing to work on.
  Result<void> open(const std::string& path);
  /// A job for a part, with a fixed axis as it lies. Errors: kUsage: a job file is open, no such machine or
  /// unit; kInput: the cutter; kIo.
  Result<void> begin(const NewDeskJob& job);
  /// Another machine that comes with the program; saving writes its profile beside the job. Errors: kUsage:
  /// there is none of this name; as edit().
  Result<void> choose_machine(const std::string& name);
  /// Changes in the text, all of them or none; keys that the changed job refuses become remarks.
  /// Errors: as set_text() and config::edited().
  Result<void> edit(const std::vector<config::YamlEdit>& edits);
  /// One operation more, less, or at another place of the list. Errors: as set_text() and config/list_edit.h;
  /// kUsage: the name is taken, or none.
  Result<void> copy_operation(std::size_t number, const std::string& name);
  Result<void> move_operation(std::size_t from, std::size_t to);
  Result<void> take_out_operation(std::size_t number);
  /// An operation states a section (or a key of no section, or of `program`) itself from now on, as the job
  /// says it for all; or no longer. Errors: as edit(); kUsage: there is no such operation or section.
  Result<void> set_own(std::size_t number, const std::string& section, bool own);
  /// The text with these changes; nothing else happens. Errors: as config::edited().
  Result<std::string> with(const std::vector<config::YamlEdit>& edits) const;
  /// A text as other processes read it, from anywhere: with the tool written out of the library that the file
  /// named when it was opened, and where its files of fixtures and blank lie. Errors: kInput: it names
  /// another file, which nobody looks at; as load_job().
  Result<std::string> whole(const std::string& text) const;
  /// Another text; it is kept whether it is right or not. Errors: kUsage: no job is open; kInput: over
  /// kMaxConfigBytes; kIo.
  Result<void> set_text(const std::string& text);
  /// Writes the text into the file that was opened; of a job that was made here into one beside the part,
  /// with its machine. Errors: kUsage: it has errors, the part has no folder, or another file has that name;
  /// kIo.
  Result<void> save();

  /// JSON: null without a job; else id (of the text), name, saved, machine, part unit, cutter, errors,
  /// operations.
  std::string describe() const;
  const std::string& text() const { return text_; }
  bool is_open() const { return id_ != 0; }
  /// By begin().
  bool is_made_here() const { return !made_.part.empty(); }
  bool is_right() const { return id_ != 0 && errors_.empty(); }
  std::uint64_t id() const { return id_; }
  /// Of a job that is right; of several operations the first that is planned.
  const config::Job& job() const { return jobs_.front(); }
  /// All of them, in the order in which they are planned.
  const std::vector<config::Job>& operations() const { return jobs_; }
  /// That of this name; empty: the first. Null: there is none.
  const config::Job* operation(const std::string& name) const;
  const std::string& file() const { return file_; }
  const std::string& machine() const { return machine_; }
  const std::string& stl() const { return stl_; }
  /// As PartWork takes it.
  std::string unit() const;

 private:
  Result<void> check();
  /// A name that no operation has, and that can be one. Errors: kUsage.
  Result<void> check_new_name(const std::string& name) const;
  /// The text names another part or machine than the desk works with.
  std::vector<JobError> other_files() const;
  /// The profile that comes with the program, as a file of this folder. Errors: kUsage: there is none; kIo.
  Result<std::string> profile_file(const std::string& name) const;
  /// The same beside a job, where it is not there yet. Errors: kUsage: another one is; kIo.
  Result<void> keep_profile(const std::string& folder) const;
  Result<void> find_place();

  std::string folder_, file_, opened_, stl_, machine_, text_, saved_;
  std::string machine_name_;        ///< as the text has to name it
  bool chosen_ = false;             ///< it comes with the program
  std::string tools_, tools_name_;  ///< the library, and as the file names it; empty: none
  std::set<std::string> files_;     ///< of fixtures and blank, as the file names them
  NewDeskJob made_;
  std::uint64_t id_ = 0;
  std::vector<JobError> errors_;
  std::vector<config::Job> jobs_{1};  ///< when it was right last
};

}  // namespace tiltfeed::desk
