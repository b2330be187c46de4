// Results that appear whole or not at all.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace scslam {

/// What an earlier result in a folder is known by.
struct ResultKind {
  std::string what;                ///< "session"
  std::string mark;                ///< file without which the folder is none
  std::vector<std::string> names;  ///< all that it may hold; anything else is the user's
};
ResultKind sessionResult();

/// A sibling of the folder that is to be made; what is in it is removed unless it takes that folder's place.
class PartialFolder {
 public:
  /// @param inputs which may not be the target. @param overwrite an earlier result may stand at `target`; it stands
  /// until replaceTarget().
  /// @throw usageError when something else stands there or it may not be replaced.
  PartialFolder(const std::filesystem::path& target, const std::vector<std::filesystem::path>& inputs,
                const ResultKind& kind, bool overwrite);
  ~PartialFolder();
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;
  const std::filesystem::path& folder() const { return partial_; }
  const std::filesystem::path& target() const { return target_; }
  /// Moves it to where it belongs.
  void replaceTarget();

 private:
  std::filesystem::path target_, partial_;
};

}  // namespace scslam
