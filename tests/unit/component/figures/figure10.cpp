// The paper's Figure 10, with one line of user code where the paper prints "...". Misprints corrected here:
// `extern "C'`, and unclosed braces.
#include <takt/module.h>

static int level = 0;

// clang-format off
extern "C"{
 int condition(){
   const bool condition = ++level > 100; // check condition;
   if(condition)
       return TRUE; // condition is met.
  else
       return FALSE; //otherwise
 }
 void initialize(void){
      level = 1; //user event initialize
 }
 void start(void){
      level = 2; //user program for start() method
 }
 void run(void){
      level = 0; //user event body
 }
  // similar methods to the .so-type periodic module
  // destruct(), error(), recover() are added
 void destruct(void){}
 void error(int type){ level = -type; }
 void recover(void){ level = 0; }
}
