# Completion of tegotae. In bash: source this file, such as in ~/.bashrc.
_tegotae() {
    local word path="" words=""
    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
        case "$path $word" in
# PATHS
        esac
    done
    case "$path" in
# COMPLETIONS
    esac
    local typed="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[*]:0:COMP_CWORD}" zoo="@ZOO@"
    # Bash splits words at colons, and completes what follows the last one.
    if [[ "$before" == *" zoo :" ]]; then
        COMPREPLY=($(compgen -W "$zoo" -- "$typed"))
        return
    elif [[ "$before" == *" zoo" && "$typed" == ":" ]]; then
        COMPREPLY=($(compgen -W "$zoo"))
        return
    elif [[ "$typed" == zoo:* ]]; then
        COMPREPLY=($(compgen -P zoo: -W "$zoo" -- "${typed#zoo:}"))
        return
    fi
    COMPREPLY=($(compgen -W "$words" -- "$typed"))
    if [[ "$path" && "$typed" && zoo: == "$typed"* ]]; then
        COMPREPLY+=(zoo:)
        compopt -o nospace 2> /dev/null
    fi
    if [[ "$path" && "$typed" != -* ]]; then
        local IFS=$'\n' marks=$'["\'\\\\]'  # a name with blanks is typed with these
        COMPREPLY+=($(compgen -f -- "${typed//$marks/}"))
    fi
}
complete -o filenames -F _tegotae tegotae
