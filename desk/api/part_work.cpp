#include "desk/api/part_work.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "config/description.h"
#include "desk/http/access_check.h"
#include "desk/view/part_view.h"
#include "pathgen/part_file/file_kind.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

std::string contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// What a program said before it failed, without our own prefix and line end.
std::string last_words(std::string text, const std::string& prefix) {
  if (text.rfind(prefix, 0) == 0) text.erase(0, prefix.size());
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.empty() ? "the part's reader ended without a word; is there memory enough?" : text;
}

/// A file of the desk is called what the user calls it.
std::string named(std::string text, const std::string& path, const std::string& name) {
  for (std::size_t at = 0; (at = text.find(path, at)) != std::string::npos; at += name.size())
    text.replace(at, path.size(), name);
  return text;
}

constexpr const char* kSamples[] = {"tyre", "pin", "sphere", "handle"};

tl::unexpected<Error> no_unit(const std::string& word) {
  return fail(Code::kUsage, "'" + word + "' is no unit of an STL; expected mm, inch or m");
}

}  // namespace

Result<void> PartWork::take(const std::string& path, const std::string& name, const std::string& unit) {
  if (!unit_length(unit)) return no_unit(unit);
  sample_.clear();
  readable_ = false;
  const std::string kept = folder_ + "/part.stl";
  child_.reset();  // the reader of the part before
  std::error_code error, error_of_model;
  std::filesystem::rename(path, kept, error);
  std::filesystem::remove(folder_ + "/model.json", error_of_model);
  if (error) return fail(Code::kIo, kept + ": " + error.message());
  stl_ = kept;
  name_ = name;
  unit_ = unit;
  return read();
}

bool PartWork::has_surfaces() const {
  return !stl_.empty() && pathgen::has_surfaces(pathgen::format_of_file(stl_));
}

void PartWork::choose(const PartChoice& choice) {
  if (choice == choice_) return;
  choice_ = choice;
  const bool there = !stl_.empty() && sample_.empty();
  if (there && pathgen::format_of_file(stl_) != pathgen::PartFormat::kMesh) (void)read();
}

Result<void> PartWork::make(const std::string& maker, const std::string& sample) {
  const bool known = std::find(std::begin(kSamples), std::end(kSamples), sample) != std::end(kSamples);
  if (!known) return fail(Code::kUsage, "there is no formula part of this name");
  child_.reset();
  Result<ChildProcess> child = ChildProcess::start({maker, "part", sample, "--out", folder_ + "/made.stl"});
  if (!child) return tl::unexpected<Error>(child.error());
  child_.emplace(std::move(*child));
  ++id_;
  seen_.clear(), error_.clear();
  name_ = sample + ".stl", unit_ = "mm", sample_ = sample, state_ = "reading";
  readable_ = false;
  tell_("part", describe());
  return {};
}

Result<void> PartWork::set_unit(const std::string& unit) {
  if (stl_.empty() || !sample_.empty()) return fail(Code::kUsage, "there is no part; open an STL first");
  if (!unit_length(unit)) return no_unit(unit);
  unit_ = unit;
  return read();
}

Result<void> PartWork::read() {
  ++id_;
  seen_.clear();
  error_.clear();
  child_.reset();
  std::vector<std::string> words{program_, "--view-part", stl_, "--unit", unit_, "--into", folder_};
  for (const std::string& body : choice_.bodies) words.push_back("--body=" + body);
  for (const std::string& face : choice_.avoid) words.push_back("--avoid=" + face);
  if (choice_.deviation > 0.0) words.push_back("--deviation=" + config::exact_text(choice_.deviation));
  Result<ChildProcess> child = ChildProcess::start(words);
  if (!child) {
    state_ = "refused";
    error_ = child.error().message;
  } else {
    state_ = "reading";
    child_.emplace(std::move(*child));
  }
  tell_("part", describe());
  return {};
}

void PartWork::hear() {
  if (!child_ || !child_->listen()) return;
  const ChildEnd end = child_->end();
  child_.reset();
  if (!sample_.empty() && end.status == 0) {
    if (const Result<void> taken = take(folder_ + "/made.stl", name_, "mm"); taken) return;
  }
  seen_ = end.status == 0 ? contents(folder_ + "/part.json") : "";
  state_ = end.status == 0 ? "ready" : "refused";
  readable_ = end.status == 0;
  if (end.status != 0) error_ = named(last_words(end.text, "tiltfeed-desk: "), stl_, name_);
  tell_("part", describe());
}

std::string PartWork::describe() const {
  if (id_ == 0) return "null";
  json about = json::parse(seen_, nullptr, false);
  if (!about.is_object()) about = json::object();
  about["id"] = id_;
  about["name"] = name_;
  about["unit"] = unit_;
  about["state"] = state_;
  std::error_code ignored;
  about["listed"] = state_ != "reading" && std::filesystem::exists(folder_ + "/model.json", ignored);
  if (!error_.empty()) about["error"] = error_;
  return about.dump(-1, ' ', true, json::error_handler_t::replace);
}

Reply PartWork::buffer(const char* file) const {
  if (state_ != "ready") return refusal(409, "there is no part that has been read");
  Reply reply;
  reply.type = kOctets;
  reply.file = folder_ + "/" + file;
  return reply;
}

Reply PartWork::model() const {
  std::error_code ignored;
  Reply reply;
  reply.file = folder_ + "/model.json";
  if (state_ == "reading" || !std::filesystem::exists(reply.file, ignored))
    return refusal(409, "there is no part that has been read");
  return reply;
}

}  // namespace tiltfeed::desk
