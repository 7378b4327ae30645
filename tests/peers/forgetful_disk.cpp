#include "tests/peers/forgetful_disk.h"

#include <sys/stat.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "tests/peers/disk_calls.h"

namespace tiltfeed {

namespace fs = std::filesystem;

/// Not on the disk yet: bytes at a place, or a cut.
struct ForgetfulDisk::Change {
  bool cut = false;
  std::uint64_t at = 0;
  std::string bytes;
};

/// Not on the disk yet: a name that is there, a name that is gone, or both at once.
struct ForgetfulDisk::NameChange {
  std::string made, gone;
  NodePtr node;
};

/// A file or a folder, as it is on the disk, and what came later.
struct ForgetfulDisk::Node {
  bool folder = false;
  std::string content;
  std::vector<Change> changes;
  std::map<std::string, NodePtr> names;
  std::vector<NameChange> name_changes;

  void apply(const NameChange& change) {
    if (!change.gone.empty()) names.erase(change.gone);
    if (!change.made.empty()) names[change.made] = change.node;
  }
  void apply(const Change& change) {
    if (change.cut) return content.resize(change.at, '\0');
    content.resize(std::max<std::size_t>(content.size(), change.at + change.bytes.size()), '\0');
    content.replace(change.at, change.bytes.size(), change.bytes);
  }
};

namespace {

/// Which of some changes reach the disk: none, all, the first ones or any.
std::vector<bool> fate_of(std::size_t count, std::mt19937_64& random) {
  const std::uint64_t way = random() % 4;
  const std::size_t first = random() % (count + 1);
  std::vector<bool> kept(count);
  for (std::size_t i = 0; i < count; ++i)
    kept[i] = way == 1 || (way == 2 && i < first) || (way == 3 && random() % 2 == 0);
  return kept;
}

/// The same bytes as pieces as large as a sector, or smaller.
constexpr std::uint64_t kPieces[] = {16, 512};

}  // namespace

ForgetfulDisk::ForgetfulDisk(std::string root) : root_(std::move(root)) {
  DiskCalls& calls = disk_calls();
  if (calls.watching || root_.size() >= sizeof calls.root) std::abort();
  top_ = look(root_);
  std::memcpy(calls.root, root_.c_str(), root_.size() + 1);
  calls.used = 0;
  calls.failing = false;
  calls.watching = true;
}

ForgetfulDisk::~ForgetfulDisk() {
  rest();
  disk_calls().watching = false;
}

void ForgetfulDisk::begin(const DiskFault& fault) {
  DiskCalls& calls = disk_calls();
  calls.fault = fault;
  calls.calls = 0;
  calls.failed[0] = '\0';
  calls.failing = true;
}

int ForgetfulDisk::calls() const { return disk_calls().calls; }
std::string ForgetfulDisk::failed() const { return disk_calls().failed; }
void ForgetfulDisk::fill(int error) {
  disk_calls().full = true;
  disk_calls().full_error = error;
  disk_calls().room = 0;
}

void ForgetfulDisk::rest() { disk_calls().failing = disk_calls().full = false; }

/// What is there, as it is.
ForgetfulDisk::NodePtr ForgetfulDisk::look(const std::string& path) {
  auto node = std::make_shared<Node>();
  struct stat status {};
  if (::fstatat(-1, path.c_str(), &status, 0) != 0) return node;
  by_inode_[status.st_ino] = node;
  node->folder = S_ISDIR(status.st_mode);
  if (node->folder) {
    for (const auto& entry : fs::directory_iterator(path))
      node->names[entry.path().filename().string()] = look(entry.path().string());
  } else {
    std::ifstream in(path, std::ios::binary);
    node->content.assign(std::istreambuf_iterator<char>(in), {});
  }
  return node;
}

void ForgetfulDisk::settle(Node& node, std::mt19937_64* random) {
  const auto kept = [&](std::size_t count) {
    return random != nullptr ? fate_of(count, *random) : std::vector<bool>(count, false);
  };
  const std::vector<bool> names = kept(node.name_changes.size()), changes = kept(node.changes.size());
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i]) node.apply(node.name_changes[i]);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (!changes[i]) continue;
    const Change& change = node.changes[i];
    if (change.cut || (*random)() % 3 != 0) {
      node.apply(change);
      continue;
    }
    const std::uint64_t piece = kPieces[(*random)() % 2];
    for (std::uint64_t at = 0; at < change.bytes.size();) {
      const std::uint64_t size = piece - (change.at + at) % piece;
      if ((*random)() % 2 == 0) node.apply({false, change.at + at, change.bytes.substr(at, size)});
      at += size;
    }
  }
  node.name_changes.clear();
  node.changes.clear();
}

void ForgetfulDisk::take(std::string_view bytes) {
  DiskEntry entry;
  std::memcpy(&entry, bytes.data(), sizeof entry);
  const std::string text(bytes.substr(sizeof entry, entry.size));
  const auto at = [this](std::uint64_t inode) -> Node& {
    const auto found = by_inode_.find(inode);
    if (found == by_inode_.end()) std::abort();  // made by a call that is not watched
    return *found->second;
  };
  switch (entry.op) {
    case DiskOp::kMake:
    case DiskOp::kFolder: {
      auto node = std::make_shared<Node>();
      node->folder = entry.op == DiskOp::kFolder;
      by_inode_[entry.inode] = node;
      at(entry.folder).name_changes.push_back({text, "", node});
      break;
    }
    case DiskOp::kWrite:
      at(entry.inode).changes.push_back({false, entry.at, text});
      break;
    case DiskOp::kCut:
      at(entry.inode).changes.push_back({true, entry.at, ""});
      break;
    case DiskOp::kSync: {
      Node& node = at(entry.inode);
      for (const Change& change : node.changes) node.apply(change);
      for (const NameChange& change : node.name_changes) node.apply(change);
      node.changes.clear();
      node.name_changes.clear();
      break;
    }
    case DiskOp::kNoSync:
      if (Node& node = at(entry.inode); !node.folder) settle(node, &fate_);
      break;
    case DiskOp::kUnlink:
      at(entry.folder).name_changes.push_back({"", text, nullptr});
      break;
    case DiskOp::kRename: {
      const std::size_t slash = text.find('/');
      at(entry.folder)
          .name_changes.push_back({text.substr(slash + 1), text.substr(0, slash), by_inode_[entry.inode]});
      break;
    }
  }
}

void ForgetfulDisk::take_log() {
  DiskCalls& calls = disk_calls();
  const std::string_view log(calls.log, calls.used);
  for (std::size_t at = 0; at < log.size();) {
    DiskEntry entry;
    std::memcpy(&entry, log.data() + at, sizeof entry);
    take(log.substr(at, sizeof entry + entry.size));
    at += sizeof entry + entry.size;
  }
  calls.used = 0;
}

void ForgetfulDisk::leave(Node& node, const std::string& path, std::mt19937_64* random) {
  settle(node, random);
  if (node.folder) {
    fs::create_directory(path);
    for (const auto& [name, child] : node.names) leave(*child, path + "/" + name, random);
  } else {
    std::ofstream(path, std::ios::binary) << node.content;
  }
}

void ForgetfulDisk::lose_power(std::mt19937_64* random) {
  take_log();
  DiskCalls& calls = disk_calls();
  calls.watching = calls.failing = false;
  fs::remove_all(root_);
  leave(*top_, root_, random);
  by_inode_.clear();
  top_ = look(root_);
  calls.watching = true;
}

}  // namespace tiltfeed
