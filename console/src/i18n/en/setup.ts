export default {
  'setup.title': 'The first administrator',
  'setup.text':
    'This hub has no users yet. The user that you name here becomes the administrator, who may do everything and adds the others.',
  'setup.no_token':
    'This hub has no users yet. Open the one-time link that it printed when it was first started; it ends in /setup# and a token.',
  'setup.user_first': 'Choose a user name',
  'setup.password': 'Password, 10 characters or more, not easily guessed',
  'setup.again': 'The password again',
  'setup.create': 'Create and log in',
  'setup.short': 'The password needs {n} characters or more',
  'setup.differ': 'The passwords differ',
  'setup.bad_link': 'This link is not valid: it has been used, or a later start of the hub has printed another one.',
};
