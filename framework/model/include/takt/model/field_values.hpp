// Converts a sample from text that a person types, for example speed=0.5 kind=box pose.x=1. For programs that
// were not compiled with the sample's type.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/type.hpp>

namespace takt::model {

/// Converts words of the form FIELD=VALUE to JSON for sample_bytes(). FIELD may be nested, as in pose.x, and
/// VALUE is written as in JSON. Strings and enumerators need no quotes. A list is given as a whole, as in
/// few=[1,2]. Fails if a word has no '=', if a field is given twice, or if a field is unknown; then the
/// problem suggests known fields. Only sample_bytes() checks whether the values are valid for the fields.
Result<std::string> json_of_words(const Type& type, const std::vector<std::string>& words);

/// Returns the JSON for sample_bytes(): `words` itself if it is a single JSON object, otherwise the result of
/// json_of_words().
Result<std::string> json_of_input(const Type& type, const std::vector<std::string>& words);

}  // namespace takt::model
