#include "scslam/apps/partial_folder.h"

#include <algorithm>

#include "scslam/core/error.h"
#include "scslam/session/layout.h"

namespace scslam {
namespace fs = std::filesystem;

ResultKind sessionResult() { return {"session", layout::kManifest, layout::allNames()}; }

PartialFolder::PartialFolder(const fs::path& target, const std::vector<fs::path>& inputs, const ResultKind& kind,
                             bool overwrite)
    : target_(fs::absolute(target).lexically_normal()) {
  if (!target_.has_filename()) target_ = target_.parent_path();
  partial_ = target_.string() + ".partial";
  std::error_code error;
  for (const fs::path& input : inputs)
    if (fs::equivalent(input, target_, error))
      throw usageError("{} is the input itself; give another folder with -o", target_.string());
  if (fs::exists(target_) && !fs::is_directory(target_))
    throw usageError("{} is a file; give another folder with -o", target_.string());
  if (fs::exists(target_) && !fs::is_empty(target_)) {
    if (!fs::is_regular_file(target_ / kind.mark))
      throw usageError("{} holds files but no {}; give another folder with -o", target_.string(), kind.what);
    if (!overwrite) throw usageError("{} already holds a {}; -w replaces it", target_.string(), kind.what);
    for (const auto& entry : fs::directory_iterator(target_))
      if (std::find(kind.names.begin(), kind.names.end(), entry.path().filename().string()) == kind.names.end())
        throw usageError("{} is not of the {} there; give another folder with -o", entry.path().string(), kind.what);
  }
  fs::remove_all(partial_, error);  // of a run that was killed
  fs::create_directories(partial_, error);
  if (error) throw inputError("cannot make folder {}: {}", partial_.string(), error.message());
}

PartialFolder::~PartialFolder() {
  std::error_code ignored;
  fs::remove_all(partial_, ignored);
}

void PartialFolder::replaceTarget() {
  std::error_code error;
  const fs::path old = target_.string() + ".replaced";
  if (fs::exists(target_)) {
    fs::remove_all(old, error);
    fs::rename(target_, old, error);
    if (error) throw inputError("cannot replace {}: {}", target_.string(), error.message());
  }
  fs::rename(partial_, target_, error);
  if (error) throw inputError("cannot make {}: {}", target_.string(), error.message());
  fs::remove_all(old, error);
}

}  // namespace scslam
