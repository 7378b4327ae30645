#include "desk/api/job_work.h"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "config/body_keys.h"
#include "config/description.h"
#include "config/job_catalogue.h"
#include "config/machine_files.h"
#include "config/named_files.h"
#include "config/new_job.h"
#include "config/output_file.h"
#include "config/yaml_tree.h"
#include "desk/view/part_view.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

/// A new job's side step as a share of the cutter's diameter, and its tolerance at most and as a share, mm.
constexpr double kStepShare = 0.1, kTolerance = 0.01, kLeastTolerance = 1e-4, kToleranceShare = 0.005;

/// A number and the ':' behind it, taken from the front of `text`; 0 where there is none.
int take_number(std::string& text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end == text.data() + text.size() || *end != ':') return 0;
  text.erase(0, static_cast<std::size_t>(end - text.data()) + 1);
  return number;
}

/// The value of a key of a map; null where it has none.
const config::YamlNode* child(const config::YamlNode& map, const char* key) {
  for (std::size_t i = 0; i < map.keys.size(); ++i)
    if (map.keys[i].text == key) return &map.items[i];
  return nullptr;
}

}  // namespace

std::vector<JobError> split_errors(const std::string& said, const std::string& path) {
  std::vector<JobError> errors;
  std::istringstream lines(said);
  for (std::string line; std::getline(lines, line);) {
    JobError error;
    if (line.rfind(path + ":", 0) == 0) {
      line.erase(0, path.size() + 1);
      error.line = take_number(line);
      error.column = take_number(line);
    }
    line.erase(0, line.find_first_not_of(' '));
    error.message = line;
    errors.push_back(error);
  }
  return errors;
}

std::vector<JobError> JobWork::other_files() const {
  const Result<config::YamlNode> now = config::parse_yaml(text_, file_),
                                 then = config::parse_yaml(saved_, file_);
  std::vector<JobError> errors;
  if (!now || !then) return errors;
  const auto compare = [&](const config::YamlNode* a, const std::string& b, const std::string& key) {
    if (a && a->text != b)
      errors.push_back({a->place.line, a->place.column,
                        key + ": the desk works with " + config::quoted(b) +
                            "; to take another file, change the job file and start tiltfeed desk again"});
  };
  const config::YamlNode *part = child(*now, "part"), *part_then = child(*then, "part");
  const config::YamlNode* stl_then = part_then ? child(*part_then, "stl") : nullptr;
  if (part && stl_then) compare(child(*part, "stl"), stl_then->text, "part.stl");
  compare(child(*now, "machine"), machine_name_, "machine");
  return errors;
}

Result<std::string> JobWork::whole(const std::string& text) const {
  const Result<config::YamlNode> now = config::parse_yaml(text, file_);
  if (!now) return tl::unexpected<Error>(now.error());
  std::vector<config::YamlEdit> places;
  bool library = false;
  for (const config::NamedFileKey& file : config::files_named_in(*now)) {
    const std::string& name = file.node->text;
    const bool tools = file.key.ends_with("library");
    const bool known = tools ? !tools_.empty() && name == tools_name_ : files_.contains(name);
    if (!known)
      return fail(Code::kInput,
                  config::to_string(file_, file.node->place) + ": " + file.key + ": the desk works with " +
                      (!tools                ? "the files that the job named when it was opened"
                       : tools_name_.empty() ? "no library"
                                             : config::quoted(tools_name_)) +
                      "; to take another file, change the job file and start tiltfeed desk again");
    library = library || tools;
    if (!tools)
      places.push_back(
          {file.key, config::quoted_text(std::filesystem::absolute(config::beside_file(opened_, name)))});
  }
  std::string out = text;
  for (const config::YamlEdit& place : places) {
    Result<std::string> changed = config::edited(out, place, {});
    if (!changed) return changed;
    out = std::move(*changed);
  }
  return library ? config::with_tool_written_out(out, file_, {stl_, machine_, tools_}) : out;
}

Result<void> JobWork::open(const std::string& path) {
  const Result<std::vector<config::Job>> jobs = config::load_operations(path, {});
  if (!jobs) return tl::unexpected<Error>(jobs.error());
  const config::Job& job = jobs->front();
  const Result<std::string> text = config::read_config_text(path);
  if (!text) return tl::unexpected<Error>(text.error());
  opened_ = path;
  stl_ = job.stl_path;
  machine_ = job.machine.path;
  chosen_ = false;
  const Result<config::YamlNode> tree = config::parse_yaml(*text, path);
  if (!tree) return tl::unexpected<Error>(tree.error());
  machine_name_ = child(*tree, "machine")->text;
  // Those of other names are errors of the text: whole().
  for (const config::NamedFileKey& file : config::files_named_in(*tree)) {
    if (!file.key.ends_with("library")) {
      files_.insert(file.node->text);
    } else if (tools_.empty()) {
      tools_name_ = file.node->text;
      tools_ = config::beside_file(path, tools_name_);
    }
  }
  saved_ = *text;
  id_ = 1;
  return set_text(*text);
}

Result<void> JobWork::begin(const NewDeskJob& wanted) {
  if (is_open() && made_.part.empty()) return fail(Code::kUsage, "a job file is open; its part has a job");
  const std::optional<double> unit = unit_length(wanted.unit);
  if (!unit) return fail(Code::kUsage, config::quoted(wanted.unit) + " is no unit of an STL");
  const Result<config::NamedCutter> cutter = config::parse_cutter(wanted.cutter);
  if (!cutter) return tl::unexpected<Error>(cutter.error());
  const Result<std::string> profile = profile_file(wanted.machine);
  if (!profile) return tl::unexpected<Error>(profile.error());
  config::NewJob job;
  job.name = config::job_name_of(wanted.part), job.stl = wanted.part, job.stl_unit_mm = *unit;
  job.machine = machine_name_ = wanted.machine + ".yaml", job.cutter = cutter->text;
  const double diameter = cutter->cutter.diameter;
  job.side_step = config::tidy(kStepShare * diameter);
  job.tolerance = std::min(kTolerance, std::max(kLeastTolerance, kToleranceShare * diameter));
  made_ = wanted;
  opened_.clear();
  stl_ = folder_ + "/part.stl", machine_ = *profile, chosen_ = true;
  const std::string text = config::new_job_text(job);
  saved_ = text;
  if (id_ == 0) id_ = 1;
  return set_text(text);
}

Result<std::string> JobWork::profile_file(const std::string& name) const {
  for (const config::MachineFile& known : config::machine_files()) {
    if (name != known.name) continue;
    const std::string path = folder_ + "/" + name + ".yaml";
    const Result<void> kept = config::write_file(path, known.text);
    return kept ? Result<std::string>(path) : tl::unexpected<Error>(kept.error());
  }
  return fail(Code::kUsage, "there is no machine " + config::quoted(name));
}

Result<void> JobWork::choose_machine(const std::string& name) {
  const Result<std::string> text = with({{"machine", name + ".yaml"}});
  if (!text) return tl::unexpected<Error>(text.error());
  const Result<std::string> profile = profile_file(name);
  if (!profile) return tl::unexpected<Error>(profile.error());
  machine_ = *profile, machine_name_ = name + ".yaml", chosen_ = true;
  return set_text(*text);
}

Result<std::string> JobWork::with(const std::vector<config::YamlEdit>& edits) const {
  if (!is_open()) return fail(Code::kUsage, "no job is open");
  std::string text = text_;
  const auto change = [&](const config::YamlEdit& edit) -> Result<void> {
    const Result<config::KeyOrder> order = config::key_order(text);
    if (!order) return fail(Code::kInput, "the text has an error that hides its keys; mend it in the text");
    Result<std::string> changed = config::edited(text, edit, *order);
    if (!changed) return tl::unexpected<Error>(changed.error());
    text = std::move(*changed);
    return {};
  };
  for (const config::YamlEdit& edit : edits)
    if (const Result<void> done = change(edit); !done) return tl::unexpected<Error>(done.error());
  const auto unused = config::unused_keys(text);
  if (!unused) return tl::unexpected<Error>(unused.error());
  for (const std::string& path : *unused)
    if (const Result<void> done = change({path, std::nullopt}); !done)
      return tl::unexpected<Error>(done.error());
  return text;
}

Result<void> JobWork::edit(const std::vector<config::YamlEdit>& edits) {
  const Result<std::string> text = with(edits);
  return text ? set_text(*text) : tl::unexpected<Error>(text.error());
}

Result<void> JobWork::set_text(const std::string& text) {
  if (!is_open()) return fail(Code::kUsage, "no job is open; start tiltfeed desk with a job file");
  if (text.size() > config::kMaxConfigBytes) return fail(Code::kInput, "a job has at most 1 MiB");
  ++id_;
  text_ = text;
  return check();
}

Result<void> JobWork::check() {
  const Result<std::string> text = whole(text_);
  std::ofstream out(file_, std::ios::binary | std::ios::trunc);
  if (!(out << (text ? *text : text_) << std::flush))
    return fail(Code::kIo, file_ + ": cannot be written; is the disk full?");
  auto jobs = text ? config::load_operations(file_, {.stl = stl_, .machine = machine_})
                   : Result<std::vector<config::Job>>(tl::unexpected<Error>(text.error()));
  errors_ = jobs ? other_files() : split_errors(jobs.error().message, file_);
  if (jobs) jobs_ = std::move(*jobs);
  return {};
}

Result<void> JobWork::find_place() {
  namespace fs = std::filesystem;
  if (made_.folder.empty())
    return fail(Code::kUsage,
                "this part came through the browser, so the desk knows no folder for its job; "
                "download the job instead");
  const std::string job = (fs::path(made_.folder) / fs::path(made_.part).stem()).string() + ".yaml";
  std::error_code ignored;
  if (fs::exists(job, ignored))
    return fail(Code::kUsage,
                fs::path(job).filename().string() + " is there already; it is not written over");
  if (const Result<void> kept = keep_profile(made_.folder); !kept) return kept;
  opened_ = job;
  return {};
}

Result<void> JobWork::keep_profile(const std::string& folder) const {
  namespace fs = std::filesystem;
  const std::string machine = (fs::path(folder) / machine_name_).string();
  std::error_code ignored;
  const Result<std::string> profile = config::read_config_text(machine_);
  if (!profile) return tl::unexpected<Error>(profile.error());
  if (fs::exists(machine, ignored)) {
    const Result<std::string> there = config::read_config_text(machine);
    if (!there || *there != *profile)
      return fail(Code::kUsage, fs::path(machine).filename().string() +
                                    " is there already and is another machine; it is not written over");
    return {};
  }
  return config::write_file(machine, *profile);
}

Result<void> JobWork::save() {
  if (!is_right()) return fail(Code::kUsage, "the job has errors, so it is not saved; mend them first");
  if (opened_.empty()) {
    if (const Result<void> place = find_place(); !place) return place;
  } else if (chosen_) {
    const Result<void> kept = keep_profile(std::filesystem::absolute(opened_).parent_path().string());
    if (!kept) return kept;
  }
  const Result<void> written = config::write_file(opened_, text_);
  if (written) saved_ = text_;
  return written;
}

}  // namespace tiltfeed::desk
