// Converts a sample from the form in which a person types it, for example speed=0.5 kind=box pose.x=1. Used
// by programs that build samples of types that they were not compiled with.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/type.hpp>

namespace takt::model {

/// Converts words of the form FIELD=VALUE to JSON for sample_bytes(). FIELD may be nested, as in pose.x, and
/// VALUE is written as in JSON. Strings and enumerators need no quotes. A list is given as a whole, as in
/// few=[1,2]. Fails if a word has no '=', if a field is given twice, or if a field is unknown; then the
/// problem suggests known fields. sample_bytes() checks whether the values are valid for the fields.
Result<std::string> json_of_words(const Type& type, const std::vector<std::string>& words);

/// If `words` is a single JSON object, returns it unchanged; otherwise converts the words with
/// json_of_words().
Result<std::string> json_of_input(const Type& type, const std::vector<std::string>& words);

}  // namespace takt::model
