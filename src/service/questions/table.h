// The table of questions.
#pragma once

#include "src/base/result.h"
#include "src/service/questions/questions_backend.h"

namespace tessera::service {

class OpenQuestion;

// To add a question: give it a name in Question::About, its file, and a row in table.cc; and a route in
// src/service/http/question_handlers.cc.
Result<QuestionAnswer> answer(const OpenQuestion& asked);

}  // namespace tessera::service
