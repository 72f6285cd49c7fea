" Vim syntax file: models of arael. Written by `python -m arael.highlighting`.
if exists("b:current_syntax")
  finish
endif

syn case match
syn keyword araelKeyword as component const constraint extern fn import in let of param ref root struct when
syn keyword araelBranch else if then
syn keyword araelLogic and not or
syn keyword araelValue false true
syn keyword araelEntity parent self
syn keyword araelConstant e epsilon identity2 identity3 pi
syn match araelKeyword "\<\(arena\|block\|compute\|deque\|derivs\|fit\|fixed\|free\|freeze\|into\|key\|list\|loss\|marginalize\|pass\|prior\|require\|skip\|skip_self_block\|solve\|symbolic\|triplets\|update\)\>\(\s*[:=.,)\]+*/^-]\)\@!"
syn match araelType "\<\(angle\|bool\|constraint_index\|direction\|euler\|int\|mat\|mat2\|mat3\|quat\|quaternion\|real\|rotation\|similarity\|string\|transform\|vec\|vec2\|vec3\)\>\(\s*(\)\@!"
syn match araelFunction "\<\(abs\|acos\|asin\|atan\|atan2\|cauchy\|cbrt\|ceil\|clamp\|col\|conj\|cos\|cosh\|cross\|dcs\|deg2rad\|det\|digamma\|dot\|erf\|erfc\|euler_angles\|exp\|expm1\|fair\|fast_atan\|fast_atan2\|floor\|geman_mcclure\|heaviside\|huber\|hypot\|identity\|inverse\|lgamma\|log\|log10\|log1p\|log2\|mat3\|matrix\|max\|min\|norm\|norm2\|normal\|perp\|pow\|quaternion\|rad2deg\|rad_diff\|rad_sum\|rotate\|rotation_matrix\|rotation_vector\|round\|row\|safe_acos\|safe_asin\|safe_atan2\|safe_sqrt\|sign\|similarity\|sin\|sinc\|sinh\|skew\|soft_l1\|sqrt\|starship\|starship_gamma\|sum\|tan\|tanh\|trace\|transform\|transpose\|tukey\|unit\|vee\|welsch\)\>\(\s*(\)\@="

syn match araelNumber "\<[0-9]\+\(\.[0-9]\+\)\?\([eE][+-]\?[0-9]\+\)\?\>"
syn match araelUnit "\(\<[a-z0-9]\+\(<[0-9, ]*>\)\?\s*\)\@<=\[[A-Za-z0-9_*/^() .-]*\]" contains=NONE
syn region araelString start=+"+ skip=+\\.+ end=+"+ end=+$+
syn match araelComment "#.*$" contains=@Spell
syn match araelStruct "\(\<\(struct\|root\|component\)\s\+\)\@<=\h\w*"
syn match araelName "\(\<\(constraint\|pass\|let\|const\|symbolic\|compute\|fn\)\s\+\)\@<=\h\w*"

hi def link araelKeyword Keyword
hi def link araelBranch Conditional
hi def link araelLogic Operator
hi def link araelValue Boolean
hi def link araelEntity Special
hi def link araelType Type
hi def link araelFunction Function
hi def link araelConstant Constant
hi def link araelNumber Number
hi def link araelUnit SpecialChar
hi def link araelString String
hi def link araelComment Comment
hi def link araelStruct Structure
hi def link araelName Identifier

let b:current_syntax = "arael"
